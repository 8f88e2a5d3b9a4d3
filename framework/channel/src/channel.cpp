#include <takt/channel/channel.hpp>

#include <new>

namespace takt::channel {

const char* to_text(Doing doing) noexcept {
  switch (doing) {
    case Doing::nothing:
      return "nothing";
    case Doing::run:
      return "run()";
    case Doing::condition:
      return "condition()";
    case Doing::initialize:
      return "initialize()";
    case Doing::start:
      return "start()";
    case Doing::error:
      return "error()";
    case Doing::recover:
      return "recover()";
    case Doing::destruct:
      return "destruct()";
    case Doing::load:
      return "loading the component";
    case Doing::serve:
      return "the handler of a service";
    case Doing::thread:
      return "a thread of the module";
  }
  return "?";
}

namespace {

constexpr std::uint64_t kChannelMagic = 0x7461'6b74'0000'0009;  // "takt" in ASCII, then the layout version: 9

struct alignas(64) ChannelHeader {
  std::uint64_t magic;
  std::uint64_t hosts;
  std::uint64_t executors;
  std::uint64_t modules;
};

constexpr std::size_t kHostsAt = sizeof(ChannelHeader);

std::size_t executors_at(std::size_t hosts) { return kHostsAt + hosts * sizeof(HostBlock); }
std::size_t size_of(std::size_t hosts, std::size_t executors, std::size_t modules) {
  return executors_at(hosts) + executors * sizeof(ExecutorBlock) + modules * sizeof(ModuleBlock);
}

template <class T>
T& at(const os::SharedMemory& memory, std::size_t offset) {
  return *std::launder(reinterpret_cast<T*>(memory.data() + offset));
}

}  // namespace

Result<Channel> Channel::create(std::size_t hosts, const std::vector<std::string>& executors,
                                const std::vector<std::string>& modules) {
  auto memory = os::SharedMemory::create("takt-channel", size_of(hosts, executors.size(), modules.size()));
  if (!memory) return memory.problems();
  at<ChannelHeader>(*memory, 0) = {
      .magic = kChannelMagic, .hosts = hosts, .executors = executors.size(), .modules = modules.size()};
  Channel channel;
  channel.memory_ = std::move(*memory);
  channel.hosts_ = hosts;
  channel.executors_ = executors.size();
  channel.modules_ = modules.size();
  for (std::size_t i = 0; i < executors.size(); ++i) channel.executor(i).name.assign(executors[i]);
  for (std::size_t i = 0; i < modules.size(); ++i) channel.module(i).name.assign(modules[i]);
  return channel;
}

Result<Channel> Channel::attach(os::Fd fd) {
  auto memory = os::SharedMemory::attach(std::move(fd));
  if (!memory) return memory.problems();
  Channel channel;
  channel.memory_ = std::move(*memory);
  if (channel.memory_.size() < sizeof(ChannelHeader))
    return fail("the shared memory of the host is not a channel", "start the host with takt-node");
  const auto& header = at<ChannelHeader>(channel.memory_, 0);
  channel.hosts_ = header.hosts;
  channel.executors_ = header.executors;
  channel.modules_ = header.modules;
  const std::size_t size = channel.memory_.size();
  // Each number is at most the size in bytes, so the computation of the total size cannot overflow.
  if (header.magic != kChannelMagic || header.hosts > size || header.executors > size ||
      header.modules > size || size != size_of(header.hosts, header.executors, header.modules)) {
    return fail("another version of Takt created the channel",
                "install takt-node and takt-host of the same version");
  }
  return channel;
}

HostBlock& Channel::host(std::size_t index) const noexcept {
  return at<HostBlock>(memory_, kHostsAt + index * sizeof(HostBlock));
}

ExecutorBlock& Channel::executor(std::size_t index) const noexcept {
  return at<ExecutorBlock>(memory_, executors_at(hosts_) + index * sizeof(ExecutorBlock));
}

ModuleBlock& Channel::module(std::size_t index) const noexcept {
  return at<ModuleBlock>(
      memory_, executors_at(hosts_) + executors_ * sizeof(ExecutorBlock) + index * sizeof(ModuleBlock));
}

}  // namespace takt::channel
