// Tests the part of the release slot through which the node gets and sets properties of a running program.
#include <takt/channel/property_mailbox.hpp>

#include <gtest/gtest.h>
#include <full_form.hpp>

#include <cstddef>
#include <cstring>
#include <string>
#include <thread>

#include <takt/channel/release_slot.hpp>
#include <takt/os/futex.hpp>

namespace takt::channel::property_mailbox_test {
namespace {

TEST(PropertyMailbox, HasNoAnswerUntilTheProgramHasAnswered) {
  PropertyRequest request{};
  PropertyAnswer answer{};
  request.ask(true, "gain", "2.5");
  EXPECT_FALSE(answer.answers(request));
  EXPECT_EQ(request.sets, 1U);
  EXPECT_EQ(request.name.view(), "gain");
  EXPECT_EQ(request.value.view(), "2.5");
  answer.answer(request.number, false, "too high");
  EXPECT_TRUE(answer.answers(request));
  EXPECT_EQ(answer.ok, 0U);
  EXPECT_EQ(answer.text.view(), "too high");
  request.ask(false, "gain", "");
  EXPECT_FALSE(answer.answers(request)) << "the answer belongs to the request before";
}

TEST(PropertyMailbox, HoldsTheLongestNameAndValue) {
  const std::string name(PropertyRequest::kMostName, 'n');
  const std::string value(PropertyRequest::kMostValue, 'v');
  PropertyRequest request{};
  request.ask(true, name, value);
  EXPECT_EQ(request.name.view(), name);
  EXPECT_EQ(request.value.view(), value);
}

TEST(PropertyMailbox, CutsOffLongAnswers) {
  PropertyAnswer answer{};
  answer.answer(1, true, std::string(PropertyAnswer::kMostText + 1, 'x'));
  EXPECT_EQ(answer.text.view(), std::string(PropertyAnswer::kMostText, 'x'));
}

TEST(PropertyMailbox, IsReadWithinItsBoundsIfTheProgramWritesNoZeroByte) {
  PropertyAnswer answer{};
  std::memset(static_cast<void*>(&answer.text), 'x', sizeof answer.text);
  EXPECT_EQ(answer.text.view().size(), sizeof answer.text);
}

TEST(PropertyMailbox, LetsTheProgramWriteOnlyTheAnswer) {
  ReleaseSlot slot{};
  for (const std::uint32_t immediate : {0U, 1U}) {
    slot.immediate = immediate;
    EXPECT_LE(offsetof(ReleaseSlot, property_request) + sizeof(PropertyRequest) + sizeof(PageGap),
              slot.read_only_size())
        << "a page must not contain both the request and what the program may write";
    EXPECT_GE(offsetof(ReleaseSlot, property_answer), slot.read_only_size());
  }
}

TEST(PropertyMailbox, ForgetsAnUnansweredRequestBeforeTheProgramIsStartedAgain) {
  ReleaseSlot slot{};
  slot.property_answer.serves = 1;
  slot.property_request.ask(true, "gain", "2.5");
  clear_for_new_program(slot);
  EXPECT_EQ(slot.property_request.number, 0U);
  EXPECT_TRUE(slot.property_answer.answers(slot.property_request));
  EXPECT_EQ(slot.property_answer.serves, 0U);
}

TEST(PropertyMailbox, PassesCompleteRequestsAndAnswersBetweenTwoThreads) {
  const int requests = how_often(20'000);
  PropertyRequest request{};
  PropertyAnswer answer{};
  std::thread program{[&] {
    for (std::uint32_t answered = 0; answered != static_cast<std::uint32_t>(requests);) {
      os::futex_wait(request.number, answered, ~0U);
      const std::uint32_t number = request.number.load(std::memory_order_acquire);
      if (number == answered) continue;
      answered = number;
      answer.answer(number, request.sets == 1,
                    std::string{request.name.view()} + "=" + std::string{request.value.view()});
    }
  }};
  int wrong = 0;
  for (int n = 1; n <= requests; ++n) {
    const std::string name(static_cast<std::size_t>(n) % PropertyRequest::kMostName, 'n');
    const std::string value = std::to_string(n);
    request.ask(n % 2 == 1, name, value);
    os::futex_wake(request.number, ~0U);
    while (!answer.answers(request)) std::this_thread::yield();
    if (answer.ok != static_cast<std::uint32_t>(n % 2) || answer.text.view() != name + "=" + value) ++wrong;
  }
  program.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace takt::channel::property_mailbox_test
