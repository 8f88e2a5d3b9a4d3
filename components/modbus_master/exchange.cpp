#include "exchange.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <utility>

#include <modbus/modbus.h>

namespace modbus {

namespace {

constexpr Seconds kFirstRetry{0.1};

std::string in_seconds(Seconds time) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f s", time.count());
  return text.data();
}

/// Returns whether the device understood the request but rejected it. The connection is then still valid.
bool is_exception(int error) { return error >= EMBXILFUN && error <= EMBXGTAR; }

const char* plural(Table table) {
  switch (table) {
    case Table::coil:
      return "coils";
    case Table::discrete:
      return "discrete inputs";
    case Table::holding:
      return "registers";
    case Table::input:
      return "input registers";
  }
  return "";
}

}  // namespace

Exchange::Exchange(std::vector<Point> points, Settings settings,
                   std::function<void(const std::string&)> report)
    : points_(std::move(points)),
      settings_(std::move(settings)),
      report_(std::move(report)),
      reads_(groups_of(points_, false, kReadLimits)),
      writes_(groups_of(points_, true, kWriteLimits)),
      retry_after_(kFirstRetry) {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    safe_.known[i] = points_[i].safe.has_value();
    safe_.value[i] = points_[i].safe.value_or(0);
    any_safe_ |= safe_.known[i];
  }
}

void Exchange::work() {
  Clock::time_point next = Clock::now();
  std::unique_lock lock{mutex_};
  while (!end_) {
    lock.unlock();
    exchange_all();
    const auto now = Clock::now();
    next += std::chrono::duration_cast<Clock::duration>(settings_.cycle);
    if (next < now) next = now;  // after a delay, skip the missed exchanges
    lock.lock();
    changed_.wait_until(lock, next, [this] { return end_; });
  }
  lock.unlock();
  write_safe();
  disconnect();
  lock.lock();
  ended_ = true;
  changed_.notify_all();
}

void Exchange::end(Seconds limit) {
  std::unique_lock lock{mutex_};
  end_ = true;
  changed_.notify_all();
  changed_.wait_for(lock, limit, [this] { return ended_; });
}

void Exchange::exchange_all() {
  const Outputs& outputs_now = wanted_outputs();
  if (device_ == nullptr && (Clock::now() < retry_at_ || !connect())) return;
  ok_ = true;
  // Write the outputs before reading the inputs, because the outputs are already one cycle old.
  for (const Group& group : writes_) {
    if (device_ != nullptr) write(group, outputs_now);
  }
  for (const Group& group : reads_) {
    if (device_ != nullptr) read(group);
  }
  if (ok_) {
    ++now_.exchanges;
    if (std::exchange(faulty_, false))
      report_("the exchange works again after " + in_seconds(Clock::now() - faulty_since_));
    rejected_.clear();
  }
  now_.connected = ok_;
  image.writing() = now_;
  image.publish();
}

/// Returns the last outputs of the cyclic body. If the body has sent no outputs for too long, because the
/// module was stopped or hangs, returns the safe values instead, unless the map has none.
const Outputs& Exchange::wanted_outputs() {
  const auto now = Clock::now();
  if (outputs.take()) {
    heard_ = now;
    ever_heard_ = true;
    if (std::exchange(silent_, false)) report_("the module runs again; the device gets its outputs again");
  }
  if (!ever_heard_ || now - heard_ < settings_.watchdog) return outputs.taken();
  if (any_safe_ && !std::exchange(silent_, true))
    report_("the module does not run; its outputs now have their safe values");
  return any_safe_ ? safe_ : outputs.taken();
}

bool Exchange::connect() {
  const auto in_microseconds = [](Seconds time) {
    return std::pair{static_cast<std::uint32_t>(time.count()),
                     static_cast<std::uint32_t>(std::fmod(time.count(), 1) * 1e6)};
  };
  device_ = modbus_new_tcp_pi(settings_.host.c_str(), std::to_string(settings_.port).c_str());
  if (device_ == nullptr) {
    failed(modbus_strerror(errno));
    return false;
  }
  const auto [seconds, microseconds] = in_microseconds(settings_.timeout);
  modbus_set_response_timeout(device_, seconds, microseconds);
  modbus_set_byte_timeout(device_, 0, 0);  // the time-out is for the whole answer, not per byte
  modbus_set_slave(device_, settings_.unit);
  if (modbus_connect(device_) == 0) {
    retry_after_ = kFirstRetry;
    return true;
  }
  failed(std::string{"no connection: "} + modbus_strerror(errno));
  return false;
}

void Exchange::disconnect() {
  if (device_ == nullptr) return;
  modbus_close(device_);
  modbus_free(device_);
  device_ = nullptr;
}

/// Handles a failed connection: closes it, because its data may still be in transit. The next exchange opens
/// a new connection.
void Exchange::failed(const std::string& what) {
  disconnect();
  ++now_.failures;
  ok_ = false;
  retry_at_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(retry_after_);
  retry_after_ = std::min(2 * retry_after_, settings_.backoff);
  now_.connected = false;
  image.writing() = now_;
  image.publish();
  if (std::exchange(faulty_, true)) return;
  faulty_since_ = Clock::now();
  report_(what + "; inputs keep their last values; retrying at least every " + in_seconds(settings_.backoff));
}

void Exchange::check_result(int result, int wanted, const char* doing, const Group& group, std::size_t first,
                            std::size_t last) {
  if (result == wanted) return;
  const int error = errno;
  const Point& begin = points_[group.points[first]];
  std::string what = std::string{doing} + " " + plural(group.table) + " " + std::to_string(begin.address) +
                     " to " + std::to_string(points_[group.points[last]].end() - 1) + " (" + begin.name +
                     (last > first ? ", ..." : "") + ")";
  if (!is_exception(error)) {
    failed("no valid answer when " + what + ": " + modbus_strerror(error));
    return;
  }
  ++now_.failures;
  ok_ = false;
  if (!std::exchange(faulty_, true)) faulty_since_ = Clock::now();
  if (rejected_.insert(what).second)
    report_("the device rejected " + what + ": " + modbus_strerror(error) +
            "; correct the map or the device");
}

void Exchange::read(const Group& group) {
  std::array<std::uint8_t, kReadLimits.bits> bits{};
  std::array<std::uint16_t, kReadLimits.registers> registers{};
  const int count = static_cast<int>(group.count);
  const int got = group.table == Table::coil ? modbus_read_bits(device_, group.address, count, bits.data())
                  : group.table == Table::discrete
                      ? modbus_read_input_bits(device_, group.address, count, bits.data())
                  : group.table == Table::holding
                      ? modbus_read_registers(device_, group.address, count, registers.data())
                      : modbus_read_input_registers(device_, group.address, count, registers.data());
  check_result(got, count, "reading", group, 0, group.points.size() - 1);
  if (got != count) return;
  for (const std::size_t i : group.points) {
    const Point& point = points_[i];
    const std::size_t at = point.address - group.address;
    const double value =
        is_bit(point.table) ? (bits[at] != 0 ? 1.0 : 0.0) : decode(point.encoding, &registers[at]);
    if (!std::isfinite(value)) continue;  // ignore a float register that holds no finite number
    now_.value[i] = value;
    ++now_.reads[i];
  }
}

/// Writes the points that have a value, with one request for adjacent points. Points without a value do not
/// change in the device.
void Exchange::write(const Group& group, const Outputs& from) {
  std::size_t first = 0;
  const auto known = [&](std::size_t place) {
    const std::size_t i = group.points[place];
    return from.known[i] && !std::isnan(from.value[i]);
  };
  while (first < group.points.size() && device_ != nullptr) {
    if (!known(first)) {
      ++first;
      continue;
    }
    std::size_t last = first;
    while (last + 1 < group.points.size() && known(last + 1)) ++last;
    write_run(group, first, last, from);
    first = last + 1;
  }
}

void Exchange::write_run(const Group& group, std::size_t first, std::size_t last, const Outputs& from) {
  std::array<std::uint8_t, kWriteLimits.bits> bits{};
  std::array<std::uint16_t, kWriteLimits.registers> registers{};
  const int address = points_[group.points[first]].address;
  const int count = static_cast<int>(points_[group.points[last]].end()) - address;
  for (std::size_t place = first; place <= last; ++place) {
    const std::size_t i = group.points[place];
    const std::size_t at = points_[i].address - static_cast<std::size_t>(address);
    if (is_bit(group.table))
      bits[at] = from.value[i] != 0 ? 1 : 0;
    else
      encode(points_[i].encoding, from.value[i], &registers[at]);
  }
  const bool bit = is_bit(group.table);
  bool& singly = singly_[bit ? 1 : 0];
  int done = 0;
  if (!singly) {
    done = bit ? modbus_write_bits(device_, address, count, bits.data())
               : modbus_write_registers(device_, address, count, registers.data());
    singly = done < 0 && errno == EMBXILFUN;
  }
  if (singly) {
    const auto write_one = [&](int at) {
      const auto place = static_cast<std::size_t>(at);
      return bit ? modbus_write_bit(device_, address + at, bits[place])
                 : modbus_write_register(device_, address + at, registers[place]);
    };
    for (done = 0; done < count && write_one(done) == 1;) ++done;
  }
  check_result(done, count, "writing", group, first, last);
}

void Exchange::write_safe() {
  if (device_ == nullptr || !any_safe_) return;
  for (const Group& group : writes_) {
    if (device_ != nullptr) write(group, safe_);
  }
}

}  // namespace modbus
