#include "web/server.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <functional>
#include <memory>
#include <semaphore>
#include <string_view>
#include <thread>
#include <utility>

#include <httplib.h>

#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>

#include "web/gateway.hpp"
#include "web/intake.hpp"

namespace takt::tool::web {

namespace {

using httplib::Request;
using httplib::Response;

constexpr std::size_t kMostWaiting = 16;  // number of requests that wait for devices at the same time
// Each stream and each request that waits for a device occupies a thread. The remaining threads answer the
// other requests.
constexpr std::size_t kThreads = Streams::kMost + kMostWaiting + 16;
constexpr std::chrono::seconds kSign{10};  // an idle stream sends a comment line this often
// Disconnect a client that reads less than this number of bytes in this time.
constexpr std::size_t kPiece = std::size_t{128} << 10;
constexpr std::chrono::seconds kWrite{10};
constexpr int kSendBuffer = 1 << 20;  // so that most responses do not wait for the client
constexpr int kBacklog = 256;         // connections that wait to be accepted; the library's number is 5

struct File {
  std::string_view path;
  std::string_view content;
};
// Not constexpr: clang would count the characters of each file, and give up after a million.
const File kFiles[] = {
#include "page.inc"
};

const char* type_of(std::string_view path) {
  const auto ends = [path](std::string_view end) {
    return path.size() >= end.size() && path.substr(path.size() - end.size()) == end;
  };
  if (ends(".html")) return "text/html; charset=utf-8";
  if (ends(".js")) return "text/javascript; charset=utf-8";
  if (ends(".css")) return "text/css; charset=utf-8";
  if (ends(".svg")) return "image/svg+xml";
  return "application/octet-stream";
}

/// Compares in constant time, so that an attacker cannot guess the token from response times.
bool is_equal(const std::string& a, const std::string& b) {
  unsigned char differs = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i)
    differs |= static_cast<unsigned char>(a[i] ^ b[i]);
  return differs == 0;
}

/// Lets the library read a complete request from memory, and write the response to the client.
class ClientStream final : public httplib::Stream {
 public:
  explicit ClientStream(Client& client) : client_(client), rest_(client.request.text()) {}

  bool is_readable() const override { return true; }
  bool is_writable() const override { return !broken_; }
  ssize_t read(char* to, size_t size) override {
    const std::size_t n = rest_.copy(to, size);
    rest_.remove_prefix(n);
    return static_cast<ssize_t>(n);
  }
  ssize_t write(const char* from, size_t size) override {
    for (std::string_view rest{from, size}; !rest.empty() && !broken_;) {
      const std::string_view piece = rest.substr(0, kPiece);
      broken_ = !client_.connection.send(piece, os::now() + kWrite);
      rest.remove_prefix(piece.size());
    }
    return broken_ ? -1 : static_cast<ssize_t>(size);
  }
  void get_remote_ip_and_port(std::string& ip, int&) const override { ip = client_.connection.peer(); }
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return INVALID_SOCKET; }

 private:
  Client& client_;
  std::string_view rest_;
  bool broken_ = false;
};

/// The library's server. It accepts connections and answers complete requests, but does not read from
/// connections.
class Library final : public httplib::Server {
 public:
  /// Sets the function that gets each accepted connection. It must not wait.
  void on_connection(std::function<void(os::Fd)> take) {
    take_ = std::move(take);
    new_task_queue = [] { return new OnThisThread; };
  }
  /// Call this after the server was bound to its port.
  void accept_bursts() { ::listen(svr_sock_, kBacklog); }
  void answer(Client& client) {
    ClientStream stream{client};
    bool closed = false;
    // Some versions of the library also want the addresses of both ends.
    const auto process = [&](auto& library) {
      if constexpr (requires { library.process_request(stream, true, closed, nullptr); })
        library.process_request(stream, true, closed, nullptr);
      else
        library.process_request(stream, client.connection.peer(), 0, "", 0, true, closed, nullptr);
    };
    process(*this);
  }

 private:
  struct OnThisThread final : httplib::TaskQueue {
    // In some versions of the library, returns true if the task was accepted.
    using Accepted = decltype(std::declval<httplib::TaskQueue&>().enqueue({}));
    Accepted enqueue(std::function<void()> task) override {
      task();
      return Accepted(true);
    }
    void shutdown() override {}
  };
  bool process_and_close_socket(socket_t socket) override {
    take_(os::Fd{socket});
    return true;
  }

  std::function<void(os::Fd)> take_;
};

class HttpServer final : public Server {
 public:
  HttpServer(Gateway& gateway, const ServerOptions& options)
      : gateway_(gateway), token_(options.token), machine_(os::host_name()), names_(options.names) {
    names_.push_back(machine_);
    server_.on_connection([this](os::Fd connection) { intake_->add(std::move(connection)); });
    server_.set_tcp_nodelay(true);
    // Do not set SO_REUSEPORT, which cpp-httplib sets by default: this option would let a second server on
    // this port take half of the requests.
    server_.set_socket_options([](socket_t socket) {
      const int yes = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
      ::setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof kSendBuffer);
    });
    server_.set_default_headers(
        {{"Content-Security-Policy",
          "default-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"},
         {"X-Content-Type-Options", "nosniff"},
         {"Referrer-Policy", "no-referrer"},
         {"Cache-Control", "no-store"}});
    server_.set_pre_routing_handler([this](const Request& request, Response& response) {
      if (is_own_name(request.get_header_value("Host"), names_))
        return httplib::Server::HandlerResponse::Unhandled;
      put(response, answer_of(421, {.where = "",
                                    .what = "the host name in the request is not a name of this machine",
                                    .fix = "open the page by its IP address, or as http://" + machine_ +
                                           ", or start takt web with --host-name and this name"}));
      return httplib::Server::HandlerResponse::Handled;
    });
    server_.set_error_handler([](const Request& request, Response& response) {
      if (!response.body.empty()) return;
      put(response, answer_of(response.status, {.where = "",
                                                .what = response.status == 404 ? "there is no " + request.path
                                                                               : "the request is malformed",
                                                .fix = "the page is at /"}));
    });
    server_.set_exception_handler([](const Request&, Response& response, const std::exception_ptr&) {
      put(response,
          answer_of(500, {.where = "", .what = "takt web failed to answer the request", .fix = ""}));
    });
    route();
  }

  ~HttpServer() override {
    gateway_.end_streams();
    server_.stop();
    if (thread_.joinable()) thread_.join();
    if (intake_) intake_->stop();
    workers_.shutdown();
  }

  Result<void> listen(const ServerOptions& options) {
    const std::string where = options.address + ":" + std::to_string(options.port);
    errno = 0;
    port_ = options.port == 0                                     ? server_.bind_to_any_port(options.address)
            : server_.bind_to_port(options.address, options.port) ? options.port
                                                                  : -1;
    if (port_ < 0) {
      const int why = errno;  // EAGAIN or 0 if the text is not an address: then no system call has failed
      return Problem{
          where,
          std::string{"cannot listen on this address"} +
              (why == 0 || why == EINVAL || why == EAGAIN ? "" : std::string{": "} + std::strerror(why)),
          why == EADDRINUSE ? "choose another --port, or 0 for any free port"
                            : "give --listen an address of this machine, or 0.0.0.0 for all its addresses"};
    }
    auto intake = Intake::create([this](const std::shared_ptr<Client>& client) {
      workers_.enqueue([this, client] {
        server_.answer(*client);
        intake_->finish(client);
      });
    });
    if (!intake) return intake.problems();
    intake_ = std::move(*intake);
    server_.accept_bursts();
    thread_ = std::thread{[this] { server_.listen_after_bind(); }};
    return {};
  }

  [[nodiscard]] int port() const noexcept override { return port_; }

 private:
  static void put(Response& response, const Answer& answer) {
    response.status = answer.status;
    response.set_content(answer.body, "application/json");
  }

  void route() {
    for (const File& file : kFiles) {
      const auto serve = [&file](const Request&, Response& response) {
        response.set_content(file.content.data(), file.content.size(), type_of(file.path));
      };
      server_.Get("/" + std::string{file.path}, serve);
      if (file.path == "index.html") server_.Get("/", serve);
    }
    server_.Get("/metrics", [this](const Request&, Response& response) {
      response.set_content(gateway_.metrics(), "text/plain; version=0.0.4; charset=utf-8");
    });
    server_.Get("/api/events", [this](const Request& request, Response& response) {
      stream(request.remote_addr, response);
    });
    DeviceRequests& requests = gateway_.device_requests();
    ask("/api/history", "module", [this](const std::string& module) { return gateway_.history(module); });
    ask("/api/faults", "before", [this](const std::string& number) { return gateway_.faults(number); });
    ask("/api/graph", "collapsed", [this](const std::string& devices) { return gateway_.graph(devices); });
    ask("/api/table", "device", [this](const std::string& device) { return gateway_.table(device); });
    ask("/api/ports", "device", [&requests](const std::string& device) { return requests.ports(device); });
    ask("/api/properties", "module",
        [this](const std::string& module) { return gateway_.properties(module); });
    server_.Put(R"(/api/streams/([0-9a-f]+)/ports)", [this](const Request& request, Response& response) {
      put(response, waiting([&] { return gateway_.watch(request.matches[1], request.body); }));
    });
    server_.Get("/api/rights", [this](const Request& request, Response& response) {
      const std::string why = refusal(request);
      put(response, answer_of(Json{{"command", why.empty()}, {"why", why}}));
    });
    post("/api/command", [&requests](const std::string& body) { return requests.command(body); });
    post("/api/acknowledge", [&requests](const std::string& body) { return requests.acknowledge(body); });
    post("/api/property", [&requests](const std::string& body) { return requests.set_property(body); });
  }

  using Answers = std::function<Answer(const std::string&)>;
  void ask(const char* path, const char* parameter, Answers answers) {
    server_.Get(path,
                [this, answers = std::move(answers), parameter](const Request& request, Response& response) {
                  put(response, waiting([&] { return answers(request.get_param_value(parameter)); }));
                });
  }
  /// Answers a request that may wait for a device and needs no token. Limits the number of these requests, so
  /// that some threads remain for the others.
  Answer waiting(const std::function<Answer()>& answer) {
    if (!may_wait_.try_acquire())
      return answer_of(503, {.where = "",
                             .what = "too many requests wait for devices: " + std::to_string(kMostWaiting),
                             .fix = "try again"});
    struct Release {
      std::counting_semaphore<kMostWaiting>& may_wait;
      ~Release() { may_wait.release(); }
    } const release{may_wait_};
    return answer();
  }
  /// Serves POST requests to `path`, which need the token.
  void post(const char* path, Answers answers) {
    server_.Post(path, [this, answers = std::move(answers)](const Request& request, Response& response) {
      const std::string why = refusal(request);
      put(response, why.empty() ? answers(request.body)
                                : answer_of(403, {.where = "",
                                                  .what = why,
                                                  .fix = "open the page with the address that takt web "
                                                         "--commands printed"}));
    });
  }

  /// The reason why the sender of a request may not send commands; empty if the sender may. Checks a header
  /// that a page of another site cannot send.
  [[nodiscard]] std::string refusal(const Request& request) const {
    if (token_.empty()) return "takt web was started without --commands";
    const std::string given = request.get_header_value("Authorization");
    if (given.empty()) return "the request has no token";
    if (!is_equal(given, "Bearer " + token_)) return "the token is wrong";
    return "";
  }

  void stream(const std::string& address, Response& response) {
    auto stream = gateway_.open(address);
    if (!stream) {
      put(response, answer_of(503, {.where = "",
                                    .what = "too many pages are open on " + address,
                                    .fix = "close another page"}));
      return;
    }
    response.set_header("X-Accel-Buffering", "no");  // nginx would otherwise hold back events
    response.set_chunked_content_provider(
        "text/event-stream",
        [stream](std::size_t, httplib::DataSink& sink) {
          const auto text = stream->next(kSign);
          if (!text) {
            sink.done();
            return true;
          }
          // The library copies what it sends. If the stream ends because the browser is too slow, the rest is
          // not sent.
          std::string_view rest = text->empty() ? kNothing : std::string_view{*text};
          while (!rest.empty() && !stream->ended()) {
            const std::string_view piece = rest.substr(0, kPiece);
            if (!sink.write(piece.data(), piece.size())) return false;
            rest.remove_prefix(piece.size());
          }
          return true;
        },
        [this, stream](bool) { gateway_.close(stream); });
  }

  static constexpr std::string_view kNothing = ": nothing new\n\n";

  Gateway& gateway_;
  const std::string token_;
  const std::string machine_;
  std::vector<std::string> names_;
  std::counting_semaphore<kMostWaiting> may_wait_{kMostWaiting};
  Library server_;
  httplib::ThreadPool workers_{kThreads};
  std::unique_ptr<Intake> intake_;
  std::thread thread_;
  int port_ = -1;
};

bool is_address(const std::string& host) {
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') return true;
  return !host.empty() && std::all_of(host.begin(), host.end(),
                                      [](unsigned char c) { return std::isdigit(c) != 0 || c == '.'; });
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace

bool is_own_name(const std::string& host, const std::vector<std::string>& names) {
  std::string name = lower(host);
  const std::size_t colon = name.rfind(':');
  if (colon != std::string::npos && name.find(']', colon) == std::string::npos) name.resize(colon);
  return is_address(name) || name == "localhost" ||
         std::any_of(names.begin(), names.end(), [&](const std::string& own) { return name == lower(own); });
}

Result<std::unique_ptr<Server>> Server::create(Gateway& gateway, const ServerOptions& options) {
  auto server = std::make_unique<HttpServer>(gateway, options);
  if (const auto listening = server->listen(options); !listening) return listening.problems();
  return std::unique_ptr<Server>{std::move(server)};
}

}  // namespace takt::tool::web
