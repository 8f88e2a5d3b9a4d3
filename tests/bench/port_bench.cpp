// What ports cost: a sample of 64 bytes written and read within a host (aim: 30 ns), across a ring in shared
// memory (aim: 300 ns), and its writing alone (aim: 200 ns). All without an allocation.
#include <benchmark/benchmark.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

#include <takt/component/in_port.hpp>
#include <takt/component/out_port.hpp>
#include <takt/os/shared_memory.hpp>

#include <port_bench.hpp>

#include "machine.hpp"

namespace {
std::atomic<std::uint64_t> allocations{0};
}

[[gnu::noinline]] void* operator new(std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  if (void* block = std::malloc(size); block != nullptr) return block;
  throw std::bad_alloc{};
}
[[gnu::noinline]] void operator delete(void* block) noexcept { std::free(block); }
[[gnu::noinline]] void operator delete(void* block, std::size_t) noexcept { std::free(block); }

namespace takt::bench {
namespace {

using Sample = ::port_bench::Sample64;

/// A writer and a reader of a connection.
struct Pair {
  explicit Pair(bool as_objects, std::uint32_t depth = 1) {
    const channel::Link::Options options{
        .depth = depth, .payload = as_objects ? 0 : PortType<Sample>::info.max_size, .is_queue = depth > 1};
    memory = std::move(os::SharedMemory::create("takt-link", channel::Link::layout(options).size()).value());
    channel::Link::format(memory.data(), options);
    const channel::Link link{memory.data()};
    void* values = as_objects ? out.make_values(link.buffers()) : nullptr;
    out.serve(context);
    in.serve(context);
    out.connect(link, values);
    in.connect(link, values);
  }
  PortContext context{.start_ns = 1};
  os::SharedMemory memory;
  OutPort<Sample> out{"out"};
  InPort<Sample> in{"in"};
};

template <class Step>
void measure(benchmark::State& state, const Step& step) {
  const std::uint64_t before = allocations.load();
  for (auto _ : state) step();
  state.counters["allocations"] = static_cast<double>(allocations.load() - before);
}

void write_and_read(benchmark::State& state, bool as_objects, std::uint32_t depth) {
  Pair pair{as_objects, depth};
  Sample sample;
  measure(state, [&] {
    ++sample.values()[0];
    pair.out.write(sample);
    if (!pair.in.read()) std::abort();
    benchmark::DoNotOptimize(pair.in.value().values()[0]);
  });
}

void write_alone(benchmark::State& state, bool as_objects) {
  Pair pair{as_objects, 8};
  Sample sample;
  measure(state, [&] {
    ++sample.values()[0];
    pair.out.write(sample);
  });
}

void read_without_news(benchmark::State& state) {
  Pair pair{true};
  measure(state, [&] { benchmark::DoNotOptimize(pair.in.read()); });
}

void write_unconnected(benchmark::State& state) {
  OutPort<Sample> out{"out"};
  Sample sample;
  measure(state, [&] { benchmark::DoNotOptimize(out.write(sample)); });
}

BENCHMARK_CAPTURE(write_and_read, in_one_host_latest, true, 1);
BENCHMARK_CAPTURE(write_and_read, in_one_host_queue, true, 8);
BENCHMARK_CAPTURE(write_and_read, across_the_ring_latest, false, 1);
BENCHMARK_CAPTURE(write_and_read, across_the_ring_queue, false, 8);
BENCHMARK_CAPTURE(write_alone, in_one_host, true);
BENCHMARK_CAPTURE(write_alone, across_the_ring, false);
BENCHMARK(read_without_news);
BENCHMARK(write_unconnected);

}  // namespace
}  // namespace takt::bench

int main(int argc, char** argv) {
  takt::bench::describe_machine();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
