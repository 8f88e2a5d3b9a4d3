#include "web/server.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <functional>
#include <string_view>
#include <thread>
#include <utility>

#include <httplib.h>

#include <takt/os/environment.hpp>

#include "web/gateway.hpp"

namespace takt::tool::web {

namespace {

using httplib::Request;
using httplib::Response;

constexpr std::size_t kMostBody = std::size_t{64} << 10;
constexpr std::size_t kThreads = Streams::kMost + 16;  // each stream occupies one thread
constexpr std::chrono::seconds kSign{10};              // an idle stream sends a comment line this often
constexpr std::chrono::seconds kWrite{10};  // disconnect a browser that reads nothing for this long

struct File {
  std::string_view path;
  std::string_view content;
};
constexpr File kFiles[] = {
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

class HttpServer final : public Server {
 public:
  HttpServer(Gateway& gateway, std::string token)
      : gateway_(gateway), token_(std::move(token)), machine_(os::host_name()) {
    server_.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
    server_.set_payload_max_length(kMostBody);
    server_.set_keep_alive_timeout(2);
    server_.set_read_timeout(5);
    server_.set_write_timeout(kWrite);
    server_.set_tcp_nodelay(true);
    // Replace the default option, SO_REUSEPORT, with which a second server on this port would get half of the
    // requests.
    server_.set_socket_options([](socket_t socket) {
      const int yes = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    server_.set_default_headers(
        {{"Content-Security-Policy",
          "default-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"},
         {"X-Content-Type-Options", "nosniff"},
         {"Referrer-Policy", "no-referrer"},
         {"Cache-Control", "no-store"}});
    server_.set_pre_routing_handler([this](const Request& request, Response& response) {
      if (is_own_name(request.get_header_value("Host"), machine_))
        return httplib::Server::HandlerResponse::Unhandled;
      put(response, answer_of(421, {.where = "",
                                    .what = "the host name in the request is not a name of this machine",
                                    .fix = "open the page by its IP address, or as http://" + machine_}));
      return httplib::Server::HandlerResponse::Handled;
    });
    server_.set_error_handler([](const Request& request, Response& response) {
      if (!response.body.empty()) return;
      const bool large = response.status == 413;
      put(response, answer_of(response.status,
                              {.where = "",
                               .what = large ? "the request is too long" : "there is no " + request.path,
                               .fix = large ? "send at most 64 KiB" : "the page is at /"}));
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
  }

  Result<void> listen(const ServerOptions& options) {
    const std::string where = options.address + ":" + std::to_string(options.port);
    errno = 0;
    port_ = options.port == 0                                     ? server_.bind_to_any_port(options.address)
            : server_.bind_to_port(options.address, options.port) ? options.port
                                                                  : -1;
    if (port_ < 0) {
      const int why = errno;
      return Problem{where,
                     std::string{"cannot listen on this address"} +
                         (why == 0 || why == EINVAL ? "" : std::string{": "} + std::strerror(why)),
                     why == EADDRINUSE
                         ? "choose another --port, or 0 for any free port"
                         : "give --listen an address of this machine, or 0.0.0.0 for all its addresses"};
    }
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
    server_.Get("/api/events", [this](const Request&, Response& response) { stream(response); });
    Questions& questions = gateway_.questions();
    ask("/api/history", "module", [this](const std::string& module) { return gateway_.history(module); });
    ask("/api/table", "device", [this](const std::string& device) { return gateway_.table(device); });
    ask("/api/ports", "device", [&questions](const std::string& device) { return questions.ports(device); });
    ask("/api/properties", "module",
        [this](const std::string& module) { return gateway_.properties(module); });
    server_.Put(R"(/api/streams/([0-9a-f]+)/ports)", [this](const Request& request, Response& response) {
      put(response, gateway_.watch(request.matches[1], request.body));
    });
    server_.Get("/api/rights", [this](const Request& request, Response& response) {
      const std::string why = refusal(request);
      put(response, answer_of(Json{{"command", why.empty()}, {"why", why}}));
    });
    post("/api/command", [&questions](const std::string& body) { return questions.command(body); });
    post("/api/property", [&questions](const std::string& body) { return questions.set_property(body); });
  }

  using Answers = std::function<Answer(const std::string&)>;
  void ask(const char* path, const char* parameter, Answers answers) {
    server_.Get(path, [answers = std::move(answers), parameter](const Request& request, Response& response) {
      put(response, answers(request.get_param_value(parameter)));
    });
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

  /// The reason why the sender of a request may not send commands; empty if it may. Checks a header that a
  /// page of another site cannot send.
  [[nodiscard]] std::string refusal(const Request& request) const {
    if (token_.empty()) return "this page is read-only: takt web was started without --commands";
    const std::string given = request.get_header_value("Authorization");
    if (given.empty()) return "the request has no token";
    if (!is_equal(given, "Bearer " + token_)) return "the token is wrong";
    return "";
  }

  void stream(Response& response) {
    auto stream = gateway_.open();
    if (!stream) {
      put(response, answer_of(503, {.where = "",
                                    .what = "too many pages are open: " + std::to_string(Streams::kMost),
                                    .fix = "close another page"}));
      return;
    }
    response.set_chunked_content_provider(
        "text/event-stream",
        [stream](std::size_t, httplib::DataSink& sink) {
          const auto text = stream->next(kSign);
          if (!text) {
            sink.done();
            return true;
          }
          const std::string& sent = text->empty() ? kNothing : *text;
          return sink.write(sent.data(), sent.size());
        },
        [this, stream](bool) { gateway_.close(stream); });
  }

  static inline const std::string kNothing = ": nothing new\n\n";

  Gateway& gateway_;
  const std::string token_;
  const std::string machine_;
  httplib::Server server_;
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

bool is_own_name(const std::string& host, const std::string& machine) {
  std::string name = lower(host);
  const std::size_t colon = name.rfind(':');
  if (colon != std::string::npos && name.find(']', colon) == std::string::npos) name.resize(colon);
  return is_address(name) || name == "localhost" || name == lower(machine);
}

Result<std::unique_ptr<Server>> Server::create(Gateway& gateway, const ServerOptions& options) {
  auto server = std::make_unique<HttpServer>(gateway, options.token);
  if (const auto listening = server->listen(options); !listening) return listening.problems();
  return std::unique_ptr<Server>{std::move(server)};
}

}  // namespace takt::tool::web
