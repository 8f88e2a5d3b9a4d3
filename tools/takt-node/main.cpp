// The program takt-node: the agent of one device.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <string_view>
#include <system_error>

#include <CLI/CLI.hpp>

#include <takt/client/network.hpp>
#include <takt/node/bridge.hpp>
#include <takt/node/inspection.hpp>
#include <takt/node/kept_deployment.hpp>
#include <takt/node/node.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/keeper.hpp>
#include <takt/os/real_time.hpp>

#include "commands/network_options.hpp"
#include "manual/pages.hpp"
#include "signatures.hpp"
#include "terminal/terminal.hpp"

namespace {

// The terminate handler: reports that the system denied takt-node memory or a thread. In this case the
// standard library throws an exception, and no code catches it on a thread of Fast DDS.
[[noreturn]] void report_exhaustion() {
  const auto report = [](const char* what) {
    std::fprintf(
        stderr,
        "takt-node: error: the system denied takt-node memory or a new thread: %s; free memory, or raise the "
        "limits: ulimit -v and -u, or MemoryMax= and TasksMax= in the systemd service of takt-node\n",
        what);
    std::_Exit(1);
  };
  try {
    if (const auto thrown = std::current_exception()) std::rethrow_exception(thrown);
  } catch (const std::system_error& error) {
    report(error.what());
  } catch (const std::bad_alloc& error) {
    report(error.what());
  } catch (...) {
  }
  std::abort();
}

}  // namespace

int main(int argc, char** argv) {
  takt::tool::require_signatures();  // before run_inspection(), which must accept only signed components too
  if (!takt::os::environment(takt::node::kInspectFd).empty()) return takt::node::run_inspection();
  if (!takt::os::environment(takt::node::kTryRights).empty()) return takt::os::may_be_real_time() ? 0 : 1;
  if (!takt::os::environment(takt::node::kGatewayFd).empty()) {
    const int status = takt::node::run_bridge(takt::client::interfaces());
    std::_Exit(status);  // skips the static destructors of Fast DDS, which sleep for a while
  }

  std::set_terminate(report_exhaustion);
  takt::os::share_heaps();

  takt::node::NodeOptions options;
  takt::client::Network network;
  options.state_folder = takt::node::default_state_folder();
  CLI::App app{
      "The agent of one device. It waits for a deployment (takt deploy), starts the device's host and "
      "programs, supervises them, and shuts them down.",
      "takt-node"};
  app.add_option("--device", options.device,
                 "name of the device that this node runs, as in the cell's descriptor")
      ->type_name("NAME")
      ->required();
  takt::tool::add_network_options(app, network);
  std::uint16_t port = 0;
  app.add_option("--serve-discovery", port, "also act as the discovery server, on this port")
      ->type_name("PORT")
      ->check(CLI::Range(1, 65535).description(""));
  const auto* state_folder =
      app.add_option("--state-dir", options.state_folder,
                     "folder for the fault record and for the deployment that --resume restores (default: "
                     "TAKT_STATE_DIR, else /var/lib/takt for root and ~/.local/state/takt for other users)")
          ->type_name("DIR");
  app.add_flag("--resume", options.resume,
               "restore the deployment that was running when the node last ended");
  app.add_flag("--require-realtime", options.require_real_time,
               "reject a deployment if the system denies real-time scheduling");
  app.add_flag("--check-realtime", options.check_real_time,
               "report allocations, locks, system calls and page faults in the real-time code of modules");
  app.add_option(
         "--signed-by", options.signed_by,
         "use only components that are signed with the key of this certificate (default: TAKT_SIGNED_BY, "
         "else components.cert.pem of the --security folder, if present)")
      ->type_name("CERT")
      ->envname("TAKT_SIGNED_BY");
  app.add_flag("--quiet", options.quiet, "print only errors");
  app.set_version_flag("--version", TAKT_VERSION);
  app.footer(R"(
SIGTERM and SIGINT shut the device down. Its deployment stays on disk for --resume, as after a power failure;
takt undeploy removes it.

Environment: TAKT_COMPONENT_PATH, TAKT_DOMAIN, TAKT_INTERFACE, TAKT_SECURITY and TAKT_STATE_DIR, as for takt.
Status: 0 clean shutdown, 1 rejected or failed (the reason is on standard error), 2 wrong usage.)");
  takt::tool::tidy_help(app);
  takt::tool::shorten_errors(app);
  if (argc == 3 && std::string_view{argv[1]} == takt::tool::kWritePages)
    return takt::tool::write_pages(app, argv[2], 8);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return takt::tool::finish(takt::tool::explain(app, error));
  }
  const auto domain = takt::client::domain_of(network);
  if (!domain) {
    std::fprintf(stderr, "takt-node: %s\n", takt::in_words(domain.problems()).c_str());
    return 2;
  }
  options.domain = *domain;
  options.state_folder_given = state_folder->count() != 0;
  // Process modules that use DDS directly, such as the recorder, read the domain of their cell from
  // TAKT_DOMAIN.
  takt::os::set_environment("TAKT_DOMAIN", std::to_string(*domain));
  options.discovery = takt::client::discovery_of(network);
  options.interfaces = takt::client::interfaces();
  options.security = takt::client::security_of(network);
  if (port != 0) {
    options.discovery.kind = takt::model::Discovery::Kind::server;
    options.discovery.serve = true;
    if (options.discovery.server.empty()) options.discovery.server = "0.0.0.0:" + std::to_string(port);
  }
  // Ends with _Exit to skip the static destructors of Fast DDS, which sleep for a while.
  takt::os::run_below_first_process();
  const int status = takt::node::run_node(options);
  std::fflush(nullptr);
  std::_Exit(status);
}
