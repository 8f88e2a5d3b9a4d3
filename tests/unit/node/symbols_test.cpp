#include <takt/node/symbols.hpp>

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <folders.hpp>

#include <cstdlib>
#include <filesystem>

// The test looks up the name and the line of this function from its address.
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
  EXPECT_EQ(symbols.name(source_path("README.md"), 0x1234), "0x1234 in README.md");
}

TEST(CallsOfModule, OmitTheOuterCallsThroughWhichTheHostCalledTheModule) {
  const std::string host = "/lib/takt-host";
  EXPECT_EQ(calls_of_module({"/m.so", host, host, "/lib/libc.so.6"}, host), 1U);
  // A function of the C++ library may be in the file of the host.
  EXPECT_EQ(calls_of_module({"/lib/libstdc++.so.6", host, "/m.so", host, host}, host), 3U);
  EXPECT_EQ(calls_of_module({"/lib/libc.so.6", host, host}, host), 3U) << "a call of the host itself";
  EXPECT_EQ(calls_of_module({"/m.so", "/m.so"}, host), 2U);
  EXPECT_EQ(calls_of_module({}, host), 0U);
}

TEST(CalledBy, BeginsWithTheLineOfTheModuleThatCallsALibrary) {
  EXPECT_EQ(called_by({"strnlen in libc.so.6", "takt_log at log.cpp:71 in libtakt_component.so.1.0",
                       "run at servo.c:9 in servo.so", "main in servo.so"},
                      1),
            "in run at servo.c:9 in servo.so, ...");
  EXPECT_EQ(called_by({"strnlen in libc.so.6", "takt_log in libtakt_component.so.1.0"}, 5), "");
}

}  // namespace
}  // namespace takt::node::symbols_test
