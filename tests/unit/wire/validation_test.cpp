#include <takt/wire/validation.hpp>

#include <string>

#include <gtest/gtest.h>

namespace takt::wire::validation_test {
namespace {

Reply reply_with(const std::string& module, const std::string& text) {
  Reply reply;
  reply.id("1");
  reply.device("line");
  reply.node("1");
  reply.parts(1);
  reply.module_name(module);
  reply.text(text);
  return reply;
}

std::string received(const std::string& text) {
  Reply reply = reply_with("arm", text);
  EXPECT_TRUE(validate(reply));
  return reply.text().c_str();
}

TEST(Validation, RemovesTerminalControlCharactersFromTexts) {
  EXPECT_EQ(received("gr\u00f6\u00dfe"), "gr\u00f6\u00dfe");
  EXPECT_EQ(received("a\x1b[31m"), "a [31m");
  EXPECT_EQ(received("a\u009b31m"), "a  31m");
  EXPECT_EQ(received("a\u202eb"), "a   b");
  EXPECT_EQ(received("a\x9b"
                     "b"),
            "a?b");
}

TEST(Validation, RejectsNamesWithTerminalControlSequences) {
  for (const char* name : {"a\x1b[31m", "a\u009b31m", "a\u0090q", "a\u202eb",
                           "a\x9b"
                           "b"}) {
    Reply reply = reply_with(name, "");
    EXPECT_FALSE(validate(reply)) << name;
  }
}

}  // namespace
}  // namespace takt::wire::validation_test
