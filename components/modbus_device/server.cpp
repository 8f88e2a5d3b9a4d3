#include "server.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include <modbus/modbus.h>

namespace modbus {

namespace {

// The server disconnects a master that does not complete a request within this time, so that such a master
// delays the other masters no longer than this.
constexpr std::uint32_t kRequestLimitUs = 100'000;

struct Span {
  unsigned begin = 65536;
  unsigned end = 0;
  [[nodiscard]] int first() const { return static_cast<int>(end == 0 ? 0 : begin); }
  [[nodiscard]] int count() const { return static_cast<int>(end == 0 ? 0 : end - begin); }
};

/// Returns the address range from the first point of the table to the last.
Span span_of(const std::vector<Point>& points, Table table) {
  Span span;
  for (const Point& point : points) {
    if (point.table != table) continue;
    span.begin = std::min<unsigned>(span.begin, point.address);
    span.end = std::max(span.end, point.end());
  }
  return span;
}

modbus_mapping_t* tables_of(const std::vector<Point>& points) {
  const auto [coil, discrete, holding, input] =
      std::array{span_of(points, Table::coil), span_of(points, Table::discrete),
                 span_of(points, Table::holding), span_of(points, Table::input)};
  const auto start = [](const Span& span) { return static_cast<unsigned>(span.first()); };
  const auto count = [](const Span& span) { return static_cast<unsigned>(span.count()); };
  return modbus_mapping_new_start_address(start(coil), count(coil), start(discrete), count(discrete),
                                          start(holding), count(holding), start(input), count(input));
}

unsigned two_bytes(const std::uint8_t* at) { return static_cast<unsigned>(at[0]) << 8 | at[1]; }

}  // namespace

Server::Server(std::vector<Point> points, Settings settings, std::function<void(const std::string&)> report)
    : points_(std::move(points)),
      settings_(std::move(settings)),
      report_(std::move(report)),
      context_(modbus_new_tcp(settings_.address.c_str(), settings_.port), modbus_free),
      tables_(tables_of(points_), modbus_mapping_free) {
  for (const Point& point : points_) {
    if (point.out && point.safe) static_cast<void>(put(point, *point.safe));
  }
}

Server::~Server() {
  for (const int client : clients_) ::close(client);
  if (listener_ >= 0) ::close(listener_);
}

std::string Server::listen() {
  if (context_ == nullptr || tables_ == nullptr)
    return "'" + settings_.address +
           "' is not an address to listen on; give an address of this machine, as in 127.0.0.1";
  listener_ = modbus_tcp_listen(context_.get(), static_cast<int>(kMaxClients));
  if (listener_ < 0) {
    return "cannot listen on " + settings_.address + ":" + std::to_string(settings_.port) + ": " +
           modbus_strerror(errno) + "; choose a free port that this user may open, usually one above 1023";
  }
  modbus_set_indication_timeout(context_.get(), 0, kRequestLimitUs);
  modbus_set_byte_timeout(context_.get(), 0, 0);
  // Before it rejects an unknown request, libmodbus waits for this timeout: 1 ms.
  modbus_set_response_timeout(context_.get(), 0, 1000);
  return "";
}

void Server::work() {
  std::vector<pollfd> watched;
  while (true) {
    watched.assign(1, pollfd{.fd = listener_, .events = POLLIN, .revents = 0});
    for (const int client : clients_) watched.push_back({.fd = client, .events = POLLIN, .revents = 0});
    static_cast<void>(::poll(watched.data(), watched.size(), 50));
    if (watched[0].revents != 0) accept_client();
    for (std::size_t i = 1; i < watched.size(); ++i) {
      if (watched[i].revents == 0 || serve(watched[i].fd)) continue;
      ::close(watched[i].fd);
      std::erase(clients_, watched[i].fd);
    }
    watch_masters();
    publish();
  }
}

void Server::accept_client() {
  const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
  if (client < 0) return;
  if (clients_.size() == kMaxClients) {
    report_("connection rejected: " + std::to_string(kMaxClients) + " masters are already connected");
    ::close(client);
    return;
  }
  // Limit the time for which one master can delay the other masters by not reading its answers or by not
  // completing its requests.
  const timeval limit{.tv_sec = 0, .tv_usec = kRequestLimitUs};
  for (const int direction : {SO_SNDTIMEO, SO_RCVTIMEO})
    static_cast<void>(::setsockopt(client, SOL_SOCKET, direction, &limit, sizeof limit));
  clients_.push_back(client);
}

bool Server::serve(int socket) {
  modbus_set_socket(context_.get(), socket);
  std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> request{};
  const int length = modbus_receive(context_.get(), request.data());
  if (length < 0) return false;
  // The header has two bytes that identify Modbus and two that hold the length of the request. libmodbus does
  // not use this length. It derives a length from the function code, and leaves the rest of an unknown
  // request unread.
  constexpr int kHeader = 6;
  if (length <= kHeader || two_bytes(&request[2]) != 0) return false;
  const int behind = static_cast<int>(two_bytes(&request[4])) + kHeader - length;
  if (behind < 0 || length + behind > MODBUS_TCP_MAX_ADU_LENGTH) return false;
  std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> rest{};
  if (behind > 0 && ::recv(socket, rest.data(), static_cast<std::size_t>(behind), MSG_WAITALL) != behind)
    return false;
  take_inputs();
  if (modbus_reply(context_.get(), request.data(), length, tables_.get()) < 0) return false;
  ++now_.requests;
  note_writes(request.data(), length);
  return true;
}

void Server::take_inputs() {
  if (!inputs.take()) return;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!points_[i].out && inputs.taken().known[i])
      static_cast<void>(put(points_[i], inputs.taken().value[i]));
  }
}

bool Server::put(const Point& point, double value) {
  modbus_mapping_t& tables = *tables_;
  switch (point.table) {
    case Table::coil:
      tables.tab_bits[point.address - tables.start_bits] = value != 0 ? 1 : 0;
      return true;
    case Table::discrete:
      tables.tab_input_bits[point.address - tables.start_input_bits] = value != 0 ? 1 : 0;
      return true;
    case Table::holding:
      return encode(point.encoding, value, &tables.tab_registers[point.address - tables.start_registers]);
    case Table::input:
      return encode(point.encoding, value,
                    &tables.tab_input_registers[point.address - tables.start_input_registers]);
  }
  return false;
}

/// Records what an answered request wrote. The server rejected a request with an invalid address, so such a
/// request wrote nothing.
void Server::note_writes(const std::uint8_t* request, int length) {
  constexpr int kPdu = 7;
  const auto at = [&](int place) {
    return kPdu + place + 1 < length ? two_bytes(request + kPdu + place) : 0U;
  };
  switch (request[kPdu]) {
    case MODBUS_FC_WRITE_SINGLE_COIL:
      return written(Table::coil, at(1), 1);
    case MODBUS_FC_WRITE_MULTIPLE_COILS:
      return written(Table::coil, at(1), at(3));
    case MODBUS_FC_WRITE_SINGLE_REGISTER:
    case MODBUS_FC_MASK_WRITE_REGISTER:
      return written(Table::holding, at(1), 1);
    case MODBUS_FC_WRITE_MULTIPLE_REGISTERS:
      return written(Table::holding, at(1), at(3));
    case MODBUS_FC_WRITE_AND_READ_REGISTERS:
      return written(Table::holding, at(5), at(7));
    default:
      return;
  }
}

void Server::written(Table table, unsigned address, unsigned count) {
  const modbus_mapping_t& tables = *tables_;
  const auto start = static_cast<unsigned>(table == Table::coil ? tables.start_bits : tables.start_registers);
  const auto size = static_cast<unsigned>(table == Table::coil ? tables.nb_bits : tables.nb_registers);
  if (address < start || address + count > start + size) return;
  written_at_ = Clock::now();
  safe_ = false;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    if (!point.out || point.table != table || point.end() <= address || address + count <= point.address)
      continue;
    const double value = table == Table::coil
                             ? tables.tab_bits[point.address - start]
                             : decode(point.encoding, &tables.tab_registers[point.address - start]);
    if (!std::isfinite(value)) continue;  // ignore a float register that holds no finite number
    now_.value[i] = value;
    ++now_.writes[i];
  }
}

void Server::watch_masters() {
  if (safe_ || settings_.watchdog == Seconds{0} || Clock::now() - written_at_ < settings_.watchdog) return;
  safe_ = true;
  bool any = false;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!points_[i].out || !points_[i].safe) continue;
    static_cast<void>(put(points_[i], *points_[i].safe));
    now_.value[i] = *points_[i].safe;
    ++now_.writes[i];
    any = true;
  }
  if (any) report_("no master has written within the watchdog time; the outputs now have their safe values");
}

void Server::publish() {
  now_.clients = static_cast<std::int64_t>(clients_.size());
  image.writing() = now_;
  image.publish();
}

}  // namespace modbus
