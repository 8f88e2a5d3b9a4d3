#include <takt/os/fiber.hpp>

#include <array>
#include <memory>
#include <string>

#include <gtest/gtest.h>

namespace takt::os::fiber_test {
namespace {

constexpr std::size_t kStack = 64 * 1024;

TEST(Fiber, ContinuesWhereItHandedOverControl) {
  std::string said;
  Fiber main;
  Fiber* self = nullptr;
  Fiber other{kStack, [&] {
                for (const char* word : {"a", "b", "c"}) {
                  said += word;
                  self->hand_over_to(main);
                }
              }};
  self = &other;
  main.hand_over_to(other);
  said += "1";
  main.hand_over_to(other);
  said += "2";
  EXPECT_EQ("a1b2", said);
}

TEST(Fiber, HasItsOwnStack) {
  Fiber main;
  std::array<int, 3> sums{};
  std::array<std::unique_ptr<Fiber>, 3> fibers;
  for (std::size_t i = 0; i < fibers.size(); ++i) {
    fibers[i] = std::make_unique<Fiber>(kStack, [&, i] {
      int sum = 0;
      for (int step = 1;; ++step) {
        std::array<volatile int, 1000> numbers{};
        for (auto& number : numbers) number = static_cast<int>(i) + step;
        fibers[i]->hand_over_to(i + 1 < fibers.size() ? *fibers[i + 1] : main);
        for (const auto& number : numbers) sum += number;
        sums[i] = sum;
      }
    });
  }
  main.hand_over_to(*fibers[0]);
  main.hand_over_to(*fibers[0]);
  EXPECT_EQ((std::array<int, 3>{1000, 2000, 3000}), sums);
}

TEST(Fiber, CatchesItsOwnExceptions) {
  Fiber main;
  Fiber* self = nullptr;
  std::string caught;
  Fiber other{kStack, [&] {
                try {
                  throw std::string{"thrown"};
                } catch (const std::string& text) {
                  caught = text;
                }
                self->hand_over_to(main);
              }};
  self = &other;
  main.hand_over_to(other);
  EXPECT_EQ("thrown", caught);
}

void return_from_a_body() {
  Fiber main;
  Fiber other{kStack, [] {}};
  main.hand_over_to(other);
}

TEST(FiberDeathTest, EndsTheProcessIfTheBodyReturns) {
  EXPECT_DEATH(return_from_a_body(), "does not return");
}

}  // namespace
}  // namespace takt::os::fiber_test
