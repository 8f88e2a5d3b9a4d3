// takt call: sends a request to a service and prints its reply.
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <random>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/client/answer_data.hpp>
#include <takt/client/connection.hpp>
#include <takt/client/identity.hpp>
#include <takt/client/port_names.hpp>
#include <takt/client/tap.hpp>
#include <takt/core/words.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/model/field_values.hpp>
#include <takt/model/json.hpp>
#include <takt/model/type.hpp>
#include <takt/os/clock.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "commands/ranges.hpp"
#include "commands/target.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

using Json = nlohmann::ordered_json;

struct CallOptions {
  std::string service;
  std::vector<std::string> request;
  double timeout = 5;  ///< s
  bool json = false;
  client::Network network;
};

/// A node opens a service to programs outside the cell only for a requested time. `takt call` requests the
/// maximum duration of the call plus this margin.
constexpr auto kMargin = std::chrono::seconds{2};
/// If DDS does not match the request topic and the reply topic within this time, the call fails.
constexpr auto kServiceFound = std::chrono::seconds{5};

/// The type of the request or reply as the user declared it, without the envelope that Takt adds.
Result<model::Type> inner(const model::Type& type, const char* field) {
  for (const model::Field& each : type.fields) {
    if (each.name == field && each.scalar == model::Scalar::structure)
      return model::Type{each.type_name, each.fields};
  }
  return fail("the device's answer is from another version of Takt",
              "install the same version on all machines");
}

/// Waits for the reply to one request, and ignores all other replies on the topic.
class Answer {
 public:
  Answer(model::Type type, std::uint64_t client) : type_(std::move(type)), client_(client) {}

  void take(const std::byte* bytes, std::size_t size) {
    std::string reply = model::sample_json(type_, bytes, size);
    const Json whole = model::parse_json(reply);
    if (!whole.contains("client") || whole.at("client") != client_) return;
    const std::lock_guard lock{mutex_};
    reply_ = std::move(reply);
    arrived_.notify_all();
  }
  /// Waits for the reply until the time `until`, and returns it as JSON. Returns an empty text if none
  /// arrived.
  std::string wait_until(Instant until) {
    std::unique_lock lock{mutex_};
    arrived_.wait_until(lock, until, [this] { return !reply_.empty(); });
    return reply_;
  }

 private:
  model::Type type_;
  std::uint64_t client_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::string reply_;
};

/// The serialized request. Fails if the fields that the user typed do not match the request's type.
Result<std::vector<std::byte>> request_of(const client::ServiceTopics& topics, const CallOptions& options,
                                          std::uint64_t client) {
  const auto type = inner(topics.request, "request");
  if (!type) return type.problems();
  const auto typed = model::json_of_input(*type, options.request);
  if (!typed) return typed.problems();
  if (const auto alone = model::sample_bytes(*type, *typed); !alone) return alone.problems();
  const Json whole{{"client", client},
                   {"number", 1},
                   {"timeout_ns", static_cast<std::int64_t>(options.timeout * 1e9)},
                   {"request", model::parse_json(*typed)}};
  return model::sample_bytes(topics.request, model::json_text(whole));
}

int call(const CallOptions& options) {
  auto name = client::parse_port(options.service);
  // With the name of a module alone, list its services.
  if (const auto module = module_of(options.service); module)
    name = client::PortName{module->device, module->module, ""};
  if (!name)
    return refuse(
        {fail(in_quotes(options.service) + " is not the name of a service", "write DEVICE.MODULE.SERVICE")});
  auto client = connect_to_device(options.network, name->device, name->module + "." + name->port);
  if (!client) return refuse(client.problems());
  if (const auto may = client::may_write(*client->participant, "call"); !may) return refuse(may.problems());
  const auto limit = std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(options.timeout));
  const auto topics = client::opened_service(*client->sender, *name, kServiceFound + kMargin + limit);
  if (!topics) return refuse(topics.problems());
  std::random_device random;
  const std::uint64_t me = (std::uint64_t{random()} << 32) | random();
  const auto request = request_of(*topics, options, me);
  if (!request) return refuse(request.problems());

  Answer answer{topics->reply, me};
  const dds::Quality quality{.reliable = true, .depth = 8, .deadline = {}, .lifespan = {}};
  dds::Quality kept = quality;
  kept.kept = true;  // also get a reply that was sent before the service discovered this reader
  const auto replies = dds::Tap::create(
      client->participant, {.topic = topics->reply_topic, .type = topics->reply, .quality = kept},
      [&answer](const std::byte* bytes, std::size_t size, std::int64_t) { answer.take(bytes, size); });
  if (!replies) return refuse(replies.problems());
  const auto requests = dds::Feed::create(
      client->participant, {.topic = topics->request_topic, .type = topics->request, .quality = quality});
  if (!requests) return refuse(requests.problems());
  const Instant found = os::now() + kServiceFound;
  while ((*requests)->health().matched == 0 || (*replies)->health().matched == 0) {
    if (os::now() > found)
      return refuse({fail(options.service + " was not found on DDS within 5 s",
                          "check with takt status that its device is still running")});
    os::sleep_until(os::now() + std::chrono::milliseconds{2});
  }
  const Instant begun = os::now();
  if (!(*requests)->write(request->data(), request->size()))
    return refuse({fail("DDS rejected the request", "see the message that DDS printed")});
  const std::string answered = answer.wait_until(begun + limit);
  const double milliseconds = std::chrono::duration<double, std::milli>(os::now() - begun).count();
  if (answered.empty()) {
    return refuse(
        {fail(fmt::format("{} did not answer within {} s; the service may still have acted on the request",
                          options.service, options.timeout),
              "check the result, or wait longer with --timeout")});
  }
  std::string code;
  std::string reason;
  Json reply;
  const auto read = client::read_answer(name->device, answered, [&](const Json& whole) {
    code = whole.at("code").get<std::string>();
    reason = whole.at("reason").get<std::string>();
    reply = whole.at("reply");
  });
  if (!read) return refuse(read.problems());
  if (code != "SERVICE_REPLIED") return refuse({fail(options.service + " rejected the request: " + reason)});
  if (options.json) {
    const double rounded = std::round(milliseconds * 1e3) / 1e3;
    return print(model::json_text({{"reply", reply}, {"ms", rounded}}) + "\n") ? 0 : 1;
  }
  std::string lines;
  for (const auto& [field, value] : reply.items())
    lines += fmt::format("{}: {}\n", field, model::json_text(value));
  return print(lines.empty() ? "done\n" : lines) ? 0 : 1;
}

}  // namespace

void add_call(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<CallOptions>();
  auto* command = app.add_subcommand("call", "Send a request to a service and print its reply");
  command
      ->add_option("SERVICE", options->service,
                   "DEVICE.MODULE.SERVICE; with DEVICE.MODULE alone, the message lists the services")
      ->required();
  command
      ->add_option("REQUEST", options->request,
                   "FIELD=VALUE ..., with OUTER.INNER=VALUE for a nested field; or one JSON object. Fields "
                   "that are left out are zero")
      ->type_name("");
  command->add_option("--timeout", options->timeout, "how long to wait for the reply (default 5)")
      ->type_name("SECONDS")
      ->check(within(0.001, 50));
  command->add_flag("--json", options->json,
                    "print one JSON object with the reply and the time that it took");
  add_network_options(*command, options->network);
  command->callback([options, &chosen] { chosen = [options] { return call(*options); }; });
}

}  // namespace takt::tool
