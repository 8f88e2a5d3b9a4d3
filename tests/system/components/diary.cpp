// Prints a line for each hook except run() and condition(), and writes the line to `file`: "initialize",
// "start", "error 2", "recover", "destruct". The first `bad_starts` calls (default 0) of start() fail. run()
// or condition() fails in its `after`-th call (default never) since the last recovery. `how` says how: throw;
// fail (run() returns a failure); slow (run() spins for `ns`, 2000000); condition (condition() throws).
#include <takt/module.h>

#include <chrono>
#include <cstdio>
#include <fstream>

static std::string file;
static std::string how;
static long long after = 0;
static long long bad_starts = 0;
static std::chrono::nanoseconds length{};
static long long runs = 0;
static long long checks = 0;

static void write(const std::string& line) {
  std::fprintf(stderr, "diary: %s\n", line.c_str());
  if (!file.empty()) std::ofstream(file, std::ios::app) << line << '\n';
}

extern "C" {
void initialize(irp::Property const& property) {
  file = property.get("file", "");
  how = property.get("how", "throw");
  after = property.get("after", 0LL, 0, 1000000000);
  bad_starts = property.get("bad_starts", 0LL, 0, 1000);
  length = std::chrono::nanoseconds{property.get("ns", 2000000LL, 0, 60000000000)};
  write("initialize");
}
void start(void) {
  write("start");
  if (bad_starts-- > 0) throw std::runtime_error("start() threw as it was asked to");
}
void run(void) {
  if (++runs != after) return;
  if (how == "throw") throw std::runtime_error("run() threw as it was asked to");
  if (how == "fail") takt_fail("run() failed as it was asked to");
  if (how != "slow") return;
  const auto end = std::chrono::steady_clock::now() + length;
  while (std::chrono::steady_clock::now() < end) {
  }
}
int condition(void) {
  if (++checks == after && how == "condition")
    throw std::runtime_error("condition() threw as it was asked to");
  return TRUE;
}
void error(int type) { write("error " + std::to_string(type)); }
void recover(void) {
  write("recover");
  runs = checks = 0;
}
void destruct(void) { write("destruct"); }
}
