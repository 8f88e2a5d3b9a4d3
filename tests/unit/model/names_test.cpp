#include <gtest/gtest.h>

#include <string>

#include <takt/model/validate.hpp>

namespace takt::model::names_test {
namespace {

TEST(Name, IsRejectedIfInvalidOrTooLong) {
  for (const char* name :
       {"", "7axis", "-a", "a.b", "a b", " a", "a ", "a/b", "gr\u00f6\u00dfe", "a\n", "a:b", "a+"}) {
    EXPECT_FALSE(is_valid_name(name)) << name;
  }
  EXPECT_FALSE(is_valid_name(std::string(64, 'a')));
  EXPECT_FALSE(is_valid_name(std::string_view{"a\0", 2}));
}

TEST(Name, MayHaveDigitsAndDashesAfterItsFirstCharacter) {
  for (const char* name : {"a", "Z", "_", "a7", "_7", "a-b", "trajectory_2", "A-"})
    EXPECT_TRUE(is_valid_name(name)) << name;
  EXPECT_TRUE(is_valid_name(std::string(63, 'a')));
}

TEST(FileStem, IsTheFileNameWithoutFolderAndExtension) {
  EXPECT_EQ(file_stem("build/controller1.so"), "controller1");
  EXPECT_EQ(file_stem("./control2.so"), "control2");
  EXPECT_EQ(file_stem("vision.exe"), "vision");
  EXPECT_EQ(file_stem("/usr/bin/vision"), "vision");
  EXPECT_EQ(file_stem("a.b/servo"), "servo");
  EXPECT_EQ(file_stem("lib.servo.so"), "lib.servo");
  EXPECT_EQ(file_stem(".so"), ".so");
  EXPECT_EQ(file_stem("folder/"), "");
  EXPECT_EQ(file_stem(""), "");
}

TEST(Topic, MustBePrintableAsciiWithoutSpaces) {
  for (const std::string topic : {"t", "rt/chatter", "takt/x", "~!\"#$%&'()*+,-./:;<=>?@[]^_`{|}", "7"}) {
    EXPECT_TRUE(is_valid_topic(topic)) << topic;
  }
  for (const std::string topic : {"", " ", "a b", "a\tb", "a\n", "\x7f", "\u00e4"}) {
    EXPECT_FALSE(is_valid_topic(topic)) << topic;
  }
  EXPECT_FALSE(is_valid_topic(std::string(1, '\0')));
  EXPECT_TRUE(is_valid_topic(std::string(kMaxTopic, 'x')));
  EXPECT_FALSE(is_valid_topic(std::string(kMaxTopic + 1, 'x')));
}

TEST(Host, MustBeAnIPv4AddressOrAHostName) {
  for (const std::string host : {"10.0.0.1", "0.0.0.0", "255.255.255.255", "localhost", "robot-1", "a.b.c",
                                 "3com", "1a.2", "my_host", "10.0.0.1.example"}) {
    EXPECT_TRUE(is_valid_host(host)) << host;
  }
  for (const std::string host : {"",           ".",          "7",         "a.",      ".a",
                                 "a..b",       "-a",         "a-",        "a.-b",    "10.0.0",
                                 "10.0.0.0.1", "10.0.0.256", "10.0.0.01", "10..0.1", "99999999999.0.0.1",
                                 "a b",        "a:1",        "::1",       "a/b",     "\u00e4"}) {
    EXPECT_FALSE(is_valid_host(host)) << host;
  }
  EXPECT_TRUE(is_valid_host(std::string(63, 'x')));
  EXPECT_FALSE(is_valid_host(std::string(64, 'x')));
  std::string longest = std::string(63, 'x') + "." + std::string(63, 'x') + "." + std::string(63, 'x') + ".";
  longest += std::string(kMaxHost - longest.size(), 'x');
  EXPECT_TRUE(is_valid_host(longest));
  EXPECT_FALSE(is_valid_host(longest + "x"));
}

TEST(Server, MustBeAHostAndAPort) {
  for (const std::string server : {"10.0.0.1:11811", "a:1", "a.b:65535"})
    EXPECT_TRUE(is_valid_server(server)) << server;
  for (const std::string server : {"", ":", "a", "a:", ":1", "a:0", "a:65536", "a:99999", "a:100000", "a:01",
                                   "a:+1", "a:-1", "a:1 ", "a:b", "a:1:2", "[::1]:1", "10.0.0.256:1"}) {
    EXPECT_FALSE(is_valid_server(server)) << server;
  }
}

TEST(TopicName, DefaultsToThePathOfTheWriter) {
  Cell cell;
  cell.name = "cell";
  Connection connection;
  connection.from = {"robot", "arm", "measured"};
  EXPECT_EQ(topic_of(cell, connection), "takt/cell/robot/arm/measured");
  connection.topic = "rt/arm";
  EXPECT_EQ(topic_of(cell, connection), "rt/arm");
}

}  // namespace
}  // namespace takt::model::names_test
