// takt web: serves a web page that shows the cell.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>

#include <takt/core/words.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/files.hpp>
#include <takt/os/signals.hpp>
#include <takt/os/writers.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "terminal/terminal.hpp"
#include "web/gateway.hpp"
#include "web/server.hpp"

namespace takt::tool {

namespace {

constexpr std::size_t kMostToken = 4096;
constexpr std::size_t kLeastToken = 16;

struct WebOptions {
  web::ServerOptions server;
  bool commands = false;
  std::string token_file;
  client::Network network;
};

/// The token that a page needs to send commands: read from the file, or random. Empty if commands are not
/// allowed.
Result<std::string> token_of(const WebOptions& options) {
  if (options.token_file.empty()) return options.commands ? web::random_word(16) : std::string{};
  namespace fs = std::filesystem;
  if (auto writers = os::check_writers(options.token_file); !writers) return writers.problems();
  std::error_code error;
  const fs::perms mode = fs::status(options.token_file, error).permissions();
  if (!error && (mode & (fs::perms::group_all | fs::perms::others_all)) != fs::perms::none) {
    return Problem{options.token_file, "is readable by other users",
                   "anyone who reads the token may command the cell; run chmod 600 " + options.token_file};
  }
  const auto content = os::read_file(options.token_file, kMostToken);
  if (!content) return content.problems();
  if (!*content) return Problem{options.token_file, "there is no such file", "write a token into the file"};
  const std::string token = (**content).substr(0, (**content).find('\n'));
  const bool plain =
      std::all_of(token.begin(), token.end(), [](unsigned char c) { return c > ' ' && c < 127; });
  if (token.size() < kLeastToken || !plain) {
    return Problem{
        options.token_file, "the first line is not a valid token",
        fmt::format("use at least {} letters and digits, for example the output of openssl rand -hex 16",
                    kLeastToken)};
  }
  return token;
}

int serve(const WebOptions& options) {
  const auto refuse = [](const Problems& problems) {
    complain(problems);
    return 1;
  };
  // Block the signals before any thread starts, because new threads inherit the set of blocked signals.
  const auto signals = os::SignalQueue::of_requests_to_end();
  if (!signals) return refuse(signals.problems());
  os::survive_broken_pipes();
  web::ServerOptions server_options = options.server;
  auto token = token_of(options);
  if (!token) return refuse(token.problems());
  server_options.token = *token;
  const auto gateway = web::Gateway::create(options.network);
  if (!gateway) return refuse(gateway.problems());
  const auto server = web::Server::create(**gateway, server_options);
  if (!server) return refuse(server.problems());
  const bool everywhere = server_options.address == "0.0.0.0" || server_options.address == "::";
  std::string host = everywhere ? os::host_name() : server_options.address;
  if (host.find(':') != std::string::npos) host = "[" + host + "]";
  const std::string url = fmt::format("http://{}:{}/", host, (*server)->port());
  std::string text = "domain " + std::to_string((*gateway)->domain()) + " is shown at " + url + "\n";
  if (options.token_file.empty() && !token->empty())
    text += "operators open " + url + "#token=" + *token + "\n";
  if (!print(text)) return 1;
  while (!signals->next()) os::wait_readable({&signals->fd()}, 1000);
  return 0;
}

}  // namespace

void add_web(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<WebOptions>();
  auto* command = app.add_subcommand(
      "web", "Serve a web page that shows every device and module live, and metrics for Prometheus");
  command->add_option("--port", options->server.port, "the TCP port on which to listen; 0: any free port")
      ->type_name("N")
      ->check(CLI::Range(0, 65535).description(""))
      ->capture_default_str();
  command
      ->add_option(
          "--listen", options->server.address,
          "the address on which to listen; 0.0.0.0: all addresses, so that other machines can open the page")
      ->type_name("ADDRESS")
      ->capture_default_str();
  command
      ->add_option(
          "--host-name", options->server.names,
          "a further host name under which the page can be opened, such as that of a proxy; repeatable")
      ->type_name("NAME")
      ->allow_extra_args(false);
  command->add_flag("--commands", options->commands,
                    "allow commands, and print a token; anyone with the token may start, stop and recover "
                    "modules and set properties. Without this option, the page is read-only");
  command
      ->add_option("--token-file", options->token_file,
                   "like --commands, but the token is the first line of this file, which no other user may "
                   "be able to read")
      ->type_name("FILE");
  add_network_options(*command, options->network);
  command->callback([options, &chosen] { chosen = [options] { return serve(*options); }; });
}

}  // namespace takt::tool
