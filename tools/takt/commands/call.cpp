// takt call: sends a request to a service and prints its reply.
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <random>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/client/connection.hpp>
#include <takt/client/identity.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/model/field_values.hpp>
#include <takt/model/json.hpp>
#include <takt/model/type.hpp>
#include <takt/os/clock.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/network_options.hpp"
#include "commands/ranges.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

using Json = nlohmann::ordered_json;

struct CallOptions {
  std::string service;
  std::vector<std::string> request;
  double timeout = 2;  ///< s
  bool json = false;
  client::Network network;
};

/// The node opens the service for other programs for a limited time. The command asks for this much more than
/// it needs.
constexpr auto kMargin = std::chrono::seconds{2};
/// If DDS does not match the request topic and the reply topic within this time, the call fails.
constexpr auto kServiceFound = std::chrono::seconds{5};

std::int64_t wall_ns() {
  return std::chrono::duration_cast<Nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

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
    Json reply = model::parse_json(model::sample_json(type_, bytes, size));
    if (!reply.is_object() || reply.value("client", std::uint64_t{0}) != client_) return;
    const std::lock_guard lock{mutex_};
    reply_ = std::move(reply);
    arrived_.notify_all();
  }
  /// Waits until a reply has arrived, at most until `until`. Null if none arrived.
  Json wait_until(Instant until) {
    std::unique_lock lock{mutex_};
    arrived_.wait_until(lock, until, [this] { return !reply_.is_null(); });
    return reply_;
  }

 private:
  model::Type type_;
  std::uint64_t client_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  Json reply_;
};

/// The request topic and the reply topic of a service, with their types.
struct Place {
  std::string request_topic;
  std::string reply_topic;
  model::Type request;
  model::Type reply;
};

Result<Place> find(client::Connection& client, const CallOptions& options) {
  const std::size_t first = options.service.find('.');
  const std::size_t second = first == std::string::npos ? first : options.service.find('.', first + 1);
  if (second == std::string::npos || second + 1 == options.service.size())
    return fail("'" + options.service + "' is not the name of a service", "write DEVICE.MODULE.SERVICE");
  const auto open_for =
      kServiceFound + kMargin +
      std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(options.timeout));
  const auto answer =
      client::accepted(client.asker->ask({.kind = COMMAND_TAP,
                                          .device = options.service.substr(0, first),
                                          .module = options.service.substr(first + 1, second - first - 1),
                                          .property = options.service.substr(second + 1),
                                          .time_ns = wall_ns() + Nanoseconds{open_for}.count()}));
  if (!answer) return answer.problems();
  const auto description = model::parse_json(answer->data);
  if (!description.is_object())
    return fail("the device's answer is from another version of Takt",
                "install the same version on all machines");
  if (!description.contains("reply"))
    return fail(options.service + " is a port, not a service",
                "show its samples with takt echo " + options.service);
  auto request = model::parse_type(description.value("type", ""));
  if (!request) return request.problems();
  auto reply = model::parse_type(description["reply"].value("type", ""));
  if (!reply) return reply.problems();
  return Place{description.value("topic", ""), description["reply"].value("topic", ""), std::move(*request),
               std::move(*reply)};
}

/// The serialized request. Fails if the fields that the user typed do not match the request's type.
Result<std::vector<std::byte>> request_of(const Place& place, const CallOptions& options,
                                          std::uint64_t client) {
  const auto type = inner(place.request, "request");
  if (!type) return type.problems();
  const auto typed = model::json_of_input(*type, options.request);
  if (!typed) return typed.problems();
  if (const auto alone = model::sample_bytes(*type, *typed); !alone) return alone.problems();
  const Json whole{{"client", client},
                   {"number", 1},
                   {"timeout_ns", static_cast<std::int64_t>(options.timeout * 1e9)},
                   {"request", model::parse_json(*typed)}};
  return model::sample_bytes(place.request, model::json_text(whole));
}

int call(const CallOptions& options) {
  const auto refuse = [](const Problems& problems) {
    complain(problems);
    return 1;
  };
  auto client = client::connect(options.network);
  if (!client) return refuse(client.problems());
  if (const auto may = client::may_write(*client->participant, "call"); !may) return refuse(may.problems());
  const auto place = find(*client, options);
  if (!place) return refuse(place.problems());
  std::random_device random;
  const std::uint64_t me = (std::uint64_t{random()} << 32) | random();
  const auto request = request_of(*place, options, me);
  if (!request) return refuse(request.problems());

  Answer answer{place->reply, me};
  const dds::Quality quality{.reliable = true, .depth = 8, .deadline = {}, .lifespan = {}};
  dds::Quality kept = quality;
  kept.kept = true;  // keep the reply for this reader, which the service may discover only after answering
  const auto replies = dds::Tap::create(
      client->participant, {.topic = place->reply_topic, .type = place->reply, .quality = kept},
      [&answer](const std::byte* bytes, std::size_t size, std::int64_t) { answer.take(bytes, size); });
  if (!replies) return refuse(replies.problems());
  const auto requests = dds::Feed::create(
      client->participant, {.topic = place->request_topic, .type = place->request, .quality = quality});
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
  const auto limit = std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(options.timeout));
  const Json reply = answer.wait_until(begun + limit);
  const double milliseconds = std::chrono::duration<double, std::milli>(os::now() - begun).count();
  if (reply.is_null()) {
    return refuse(
        {fail(fmt::format("{} did not answer within {} s; the service may still have acted on the request",
                          options.service, options.timeout),
              "check the result, or wait longer with --timeout")});
  }
  if (reply.value("code", "") != "SERVICE_REPLIED")
    return refuse({fail(options.service + " rejected the request: " + reply.value("reason", ""))});
  if (options.json) {
    const double rounded = std::round(milliseconds * 1e3) / 1e3;
    return print(model::json_text({{"reply", reply.at("reply")}, {"ms", rounded}}) + "\n") ? 0 : 1;
  }
  std::string lines;
  for (const auto& [name, value] : reply.at("reply").items())
    lines += fmt::format("{}: {}\n", name, model::json_text(value));
  return print(lines.empty() ? "done\n" : lines) ? 0 : 1;
}

}  // namespace

void add_call(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<CallOptions>();
  auto* command = app.add_subcommand("call", "Send a request to a service and print its reply");
  command->add_option("SERVICE", options->service, "DEVICE.MODULE.SERVICE")->required();
  command
      ->add_option("REQUEST", options->request,
                   "FIELD=VALUE ..., with OUTER.INNER=VALUE for a nested field; or one JSON object. Fields "
                   "that are left out are zero")
      ->type_name("");
  command->add_option("--timeout", options->timeout, "how long to wait for the reply (default 2)")
      ->type_name("SECONDS")
      ->check(within(0.001, 50));
  command->add_flag("--json", options->json,
                    "print one JSON object with the reply and the time that it took");
  add_network_options(*command, options->network);
  command->callback([options, &chosen] { chosen = [options] { return call(*options); }; });
}

}  // namespace takt::tool
