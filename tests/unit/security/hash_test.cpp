#include <takt/security/hash.hpp>

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include <takt/os/environment.hpp>

namespace takt::security::hash_test {
namespace {

TEST(ShortHash, IsTheBeginningOfTheSha256OfTheFile) {
  const std::string file =
      testing::TempDir() + "takt-hash-" + std::to_string(os::process_id());
  std::ofstream{file} << "abc";
  EXPECT_EQ(short_hash(file), "ba7816bf");
  std::ofstream{file} << "abd";
  EXPECT_NE(short_hash(file), "ba7816bf");
  std::filesystem::remove(file);
  EXPECT_EQ(short_hash(file), "");
}

}  // namespace
}  // namespace takt::security::hash_test
