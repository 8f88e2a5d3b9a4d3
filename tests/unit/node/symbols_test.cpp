#include <takt/node/symbols.hpp>

#include <dlfcn.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>

// The test looks up the name and line of this function.
extern "C" [[gnu::noinline]] int takt_symbols_test_function(int x) { return x + std::rand(); }

namespace takt::node::symbols_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::uint64_t address_in_file(const void* address) {
  Dl_info info{};
  EXPECT_NE(::dladdr(address, &info), 0);
  return reinterpret_cast<std::uintptr_t>(address) - reinterpret_cast<std::uintptr_t>(info.dli_fbase);
}

TEST(Symbols, DescribesAnAddressByFunctionLineAndObjectFile) {
  const std::string program = std::filesystem::read_symlink("/proc/self/exe");
  Symbols symbols;
  const std::uint64_t address = address_in_file(reinterpret_cast<const void*>(&takt_symbols_test_function));
  for (int again = 0; again < 2; ++again) {
    EXPECT_THAT(symbols.name(program, address),
                AllOf(StartsWith("takt_symbols_test_function"), HasSubstr(" at symbols_test.cpp:"),
                      HasSubstr(" in " + std::filesystem::path{program}.filename().string())));
  }
}

TEST(Symbols, ShowsTheBareAddressIfItsFunctionIsUnknown) {
  Symbols symbols;
  EXPECT_EQ(symbols.name("", 0x1234), "0x1234");
  EXPECT_EQ(symbols.name("/nowhere/module.so", 0x1234), "0x1234 in module.so");
  EXPECT_EQ(symbols.name(TAKT_SOURCE_DIR "/README.md", 0x1234), "0x1234 in README.md");
}

}  // namespace
}  // namespace takt::node::symbols_test
