#include <random>

#include <gtest/gtest.h>

#include <takt/wire/assembly.hpp>
#include <takt/wire/compression.hpp>

namespace takt::wire::compression_test {

std::string random_bytes(std::size_t size) {
  std::mt19937 random{1};
  std::string bytes;
  while (bytes.size() < size) bytes.push_back(static_cast<char>(random()));
  return bytes;
}

TEST(Compression, ShortDataAreSentUnchanged) {
  EXPECT_EQ(packed(""), "");
  const std::string longest(kPart, '<');
  EXPECT_EQ(packed(longest), longest);
  EXPECT_EQ(unpacked(longest), longest);
}

TEST(Compression, RepetitiveDataShrinkToOneSample) {
  const std::string data(60UL * kPart, '<');
  EXPECT_LE(packed(data).size(), kPart);
  EXPECT_EQ(unpacked(packed(data)), data);
}

TEST(Compression, DataThatDoNotShrinkAreSentUnchanged) {
  const std::string data = "<" + random_bytes(5000);
  EXPECT_EQ(packed(data), data);
}

TEST(Compression, AnyDataComeBackAsTheyWere) {
  for (const std::size_t size : {kPart + 1, 64UL * 1024, 64UL * 1024 + 1, 300UL * 1024}) {
    EXPECT_EQ(unpacked(packed(random_bytes(size))), random_bytes(size)) << size;
  }
}

TEST(Compression, TheLongestDataComeBackAsTheyWere) {
  const std::string longest(kMaxData, '<');
  EXPECT_TRUE(unpacked(packed(longest)) == longest);
}

TEST(Compression, DataThatBeginLikeAStreamComeBackAsTheyWere) {
  EXPECT_EQ(unpacked(packed("x = 1")), "x = 1");
}

TEST(Compression, DamagedDataAreRejected) {
  const std::string stream = packed("x" + random_bytes(2000));
  EXPECT_FALSE(unpacked(stream.substr(0, stream.size() / 2))) << "its end is missing";
  EXPECT_FALSE(unpacked("x = 1"));
  std::string other = stream;
  other[1000] = static_cast<char>(other[1000] ^ 1);
  EXPECT_FALSE(unpacked(other)) << "one bit is changed";
}

TEST(Compression, AShortStreamOfEndlessDataIsRejected) {
  const std::string stream = packed(std::string(kMaxData + 1, '<'));
  EXPECT_LT(stream.size(), 20000U);
  EXPECT_FALSE(unpacked(stream));
}

}  // namespace takt::wire::compression_test
