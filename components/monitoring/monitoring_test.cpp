#include "machine.h"

#include <gtest/gtest.h>

namespace {

TEST(MachineStatus, TakesTheFirstNumberAsTheLoad) {
  EXPECT_EQ(machine_load("0.52 0.58 0.59 1/467 12345\n"), 0.52);
}

TEST(MachineStatus, ReportsANegativeLoadIfTheTextIsEmpty) { EXPECT_LT(machine_load(""), 0); }

TEST(MachineStatus, FindsAMemoryValueByItsWholeName) {
  const char* text = "MemTotal:       8000000 kB\nMemFree:         100000 kB\nMemAvailable:   4000000 kB\n";
  EXPECT_EQ(machine_memory_kib(text, "MemTotal"), 8000000);
  EXPECT_EQ(machine_memory_kib(text, "MemAvailable"), 4000000);
  EXPECT_LT(machine_memory_kib(text, "Mem"), 0);
  EXPECT_EQ(machine_memory_kib("MemTotal: 8 kB\nMem: 5 kB\n", "Mem"), 5);
  EXPECT_LT(machine_memory_kib(text, "SwapTotal"), 0);
  EXPECT_LT(machine_memory_kib("", "MemTotal"), 0);
}

}  // namespace
