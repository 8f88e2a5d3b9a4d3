// The ports of modules in the C form, and of programs: part of libtakt_component and of libtakt_process.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include <takt/component/port.h>
#include <takt/component/in_port.hpp>
#include <takt/component/out_port.hpp>

namespace takt {
namespace {

TypeInfo info_of(const takt_type& type) { return {type.name, type.description, type.max_size}; }

/// Room for one value of any C struct.
class Value {
 public:
  explicit Value(std::uint32_t size) : words_(size / sizeof(std::max_align_t) + 1) {}
  [[nodiscard]] void* get() noexcept { return words_.data(); }

 private:
  std::vector<std::max_align_t> words_;
};

class CInPort final : public InPortBase {
 public:
  explicit CInPort(const takt_port& port)
      : InPortBase(nullptr, port.name,
                   port.direction == TAKT_EVENT ? PortDirection::event : PortDirection::in, info_, {}),
        info_(info_of(*port.type)),
        c_type_(*port.type) {
    std::memset(last_->get(), 0, c_type_.value_size);
  }

  bool read(void* value) noexcept {
    const bool found = next();
    std::memcpy(value, last_->get(), c_type_.value_size);
    return found;
  }

  void connect(channel::Link link, void* values) override {
    TAKT_CHECK(values == nullptr);
    add(link, nullptr);
  }
  [[nodiscard]] void* make_values(std::uint32_t) const override { return nullptr; }
  [[nodiscard]] std::size_t value_size() const noexcept override { return 0; }

 private:
  bool next() noexcept {
    begin_read();
    for (int refused = 0; refused < kMostRefused; ++refused) {
      Source* source = take();
      if (source == nullptr) return false;
      const channel::SampleInfo info = source->reader.info();
      const auto* bytes =
          reinterpret_cast<const unsigned char*>(source->reader.link().payload(source->reader.buffer()));
      if (c_type_.decode(bytes, info.size, other_->get()) == 0) {
        refuse(*source);
        continue;
      }
      std::swap(last_, other_);
      accept(info);
      return true;
    }
    return false;
  }

  TypeInfo info_;
  const takt_type& c_type_;
  Value first_{c_type_.value_size};
  Value second_{c_type_.value_size};
  Value* last_ = &first_;  // what is no sample is decoded into the other one
  Value* other_ = &second_;
};

class COutPort final : public OutPortBase {
 public:
  explicit COutPort(const takt_port& port)
      : OutPortBase(nullptr, port.name, PortDirection::out, info_, {}),
        info_(info_of(*port.type)),
        c_type_(*port.type) {}

  bool write(const void* value) noexcept {
    const auto encode = [&](std::byte* to, std::uint32_t size) noexcept {
      return c_type_.encode(value, reinterpret_cast<unsigned char*>(to), size);
    };
    return write_all(encode, [](void*, std::uint32_t) noexcept {}) == Written::yes;
  }

  void connect(channel::Link link, void* values) override {
    TAKT_CHECK(values == nullptr && link.stride() >= info_.max_size);
    add(link, nullptr);
  }
  [[nodiscard]] void* make_values(std::uint32_t) const override { return nullptr; }
  [[nodiscard]] std::size_t value_size() const noexcept override { return 0; }

 private:
  TypeInfo info_;
  const takt_type& c_type_;
};

CInPort* reader_of(const takt_port* port) noexcept {
  return port->direction == TAKT_OUT ? nullptr : static_cast<CInPort*>(port->inside);
}
COutPort* writer_of(const takt_port* port) noexcept {
  return port->direction == TAKT_OUT ? static_cast<COutPort*>(port->inside) : nullptr;
}

}  // namespace
}  // namespace takt

extern "C" {

void takt_add_port(takt_port* port) {
  port->inside = port->direction == TAKT_OUT ? static_cast<void*>(new takt::COutPort{*port})
                                             : static_cast<void*>(new takt::CInPort{*port});
}

void takt_remove_port(takt_port* port) {
  delete takt::reader_of(port);
  delete takt::writer_of(port);
  port->inside = nullptr;
}

int takt_port_read(takt_port* port, void* value) {
  auto* reader = takt::reader_of(port);
  return reader != nullptr && reader->read(value) ? 1 : 0;
}

int takt_port_write(takt_port* port, const void* value) {
  auto* writer = takt::writer_of(port);
  return writer != nullptr && writer->write(value) ? 1 : 0;
}

int takt_port_has_news(const takt_port* port) {
  const auto* reader = takt::reader_of(port);
  return reader != nullptr && reader->has_news() ? 1 : 0;
}

int takt_port_is_new(const takt_port* port) {
  const auto* reader = takt::reader_of(port);
  return reader != nullptr && reader->is_new() ? 1 : 0;
}

int takt_port_connected(const takt_port* port) {
  const auto* reader = takt::reader_of(port);
  const auto* writer = takt::writer_of(port);
  return (reader != nullptr && reader->connected()) || (writer != nullptr && writer->connected()) ? 1 : 0;
}

uint64_t takt_port_sequence(const takt_port* port) {
  const auto* reader = takt::reader_of(port);
  return reader == nullptr ? 0 : reader->sequence();
}

int64_t takt_port_age_ns(const takt_port* port) {
  const auto* reader = takt::reader_of(port);
  return reader == nullptr ? std::numeric_limits<int64_t>::max() : reader->age().count();
}
}
