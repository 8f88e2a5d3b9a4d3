// The functions of <takt/port.h>, for thread modules and process modules in C. Part of libtakt_component and
// of libtakt_process.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include <takt/port.h>
#include <takt/component/in_port.hpp>
#include <takt/component/out_port.hpp>

namespace takt {
namespace {

TypeInfo info_of(const takt_type& type) { return {type.name, type.description, type.max_size}; }

/// Memory for one value of any C struct.
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
    if (watched() && know_safe()) settle(found);
    if (may_be_forced()) {
      settle_force([this](const std::byte* bytes, std::uint32_t size) noexcept {
        return c_type_.decode(reinterpret_cast<const unsigned char*>(bytes), size, forced_.get()) != 0;
      });
    }
    Value* const shown = is_forced() ? &forced_ : is_safe() ? &safe_ : last_;
    std::memcpy(value, shown->get(), c_type_.value_size);
    return is_new();
  }

  void connect(channel::Link link, void* values) override {
    TAKT_CHECK(values == nullptr);
    if (const Source* before = add(link, nullptr); before != nullptr && decode(*before))
      take_back(before->reader.info());
    safe_known_ = false;
  }
  void take_over(PortBase& before) noexcept override {
    auto& other = static_cast<CInPort&>(before);
    other.drop_force();
    follow(other);
    std::memcpy(last_->get(), other.last_->get(), c_type_.value_size);
    if (is_safe()) static_cast<void>(know_safe());
  }
  [[nodiscard]] void* make_values(std::uint32_t) const override { return nullptr; }
  [[nodiscard]] std::size_t value_size() const noexcept override { return 0; }

 private:
  bool know_safe() noexcept {
    if (safe_known_) return true;
    const auto bytes = watched().safe();
    safe_known_ =
        !bytes.empty() && c_type_.decode(reinterpret_cast<const unsigned char*>(bytes.data()),
                                         static_cast<std::uint32_t>(bytes.size()), safe_.get()) != 0;
    return safe_known_;
  }
  bool next() noexcept {
    begin_read();
    for (int refused = 0; refused < kMostRefused; ++refused) {
      Source* source = take();
      if (source == nullptr) return false;
      if (!decode(*source)) {
        refuse(*source);
        continue;
      }
      accept(source->reader.info());
      return true;
    }
    return false;
  }
  bool decode(const Source& source) noexcept {
    const channel::LinkReader& reader = source.reader;
    const auto* bytes = reinterpret_cast<const unsigned char*>(reader.link().payload(reader.buffer()));
    if (c_type_.decode(bytes, reader.info().size, other_->get()) == 0) return false;
    std::swap(last_, other_);
    return true;
  }

  TypeInfo info_;
  const takt_type& c_type_;
  Value first_{c_type_.value_size};
  Value second_{c_type_.value_size};
  Value safe_{c_type_.value_size};
  Value forced_{c_type_.value_size};
  bool safe_known_ = false;
  Value* last_ = &first_;  // samples are decoded into *other_, so an invalid sample does not change *last_
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

int takt_port_is_safe(const takt_port* port) {
  const auto* reader = takt::reader_of(port);
  return reader != nullptr && reader->is_safe() ? 1 : 0;
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
