#include "validate_network.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include <takt/core/words.hpp>

namespace takt::model {

namespace {

/// Returns true if the name is a ROS 2 topic name without its leading slash: words separated by single
/// slashes.
bool is_ros2_name(std::string_view name) {
  bool begins = true;
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    const bool digit = c >= '0' && c <= '9';
    if (begins ? !letter : !letter && !digit && c != '/') return false;
    begins = c == '/';
  }
  return !begins;
}

constexpr const char* kTopicRule = "a topic name has 1 to 255 printable ASCII characters and no spaces";

/// Returns the fix for an unknown name: a similar known name or, if no name is known, to add an element.
std::string choose(const char* kind, std::string_view wrong, const std::vector<std::string_view>& names) {
  if (names.empty()) return std::string{"add a <"} + kind + "> with this name";
  return suggestion(wrong, names);
}

/// Returns true if the descriptor omits this end of a connection. An end with at least one part is not
/// omitted.
bool is_missing(const Endpoint& end) { return end.device.empty() && end.module.empty() && end.port.empty(); }

using Key = std::tuple<const std::string&, const std::string&, const std::string&>;
Key key(const Endpoint& end) { return {end.device, end.module, end.port}; }

using Connections = std::vector<const Connection*>;

class Network {
 public:
  Network(const Cell& cell, const Gaps& gaps, Findings& findings)
      : cell_(cell), gaps_(gaps), findings_(findings) {}

  void check_discovery();
  void check_connections();
  /// Requires that check_connections() was called before.
  void check_services();

 private:
  /// The modules of all devices with one name. check_names() reports a second device with the same name, but
  /// references to the modules of either device are accepted.
  struct Known {
    bool gaps = false;
    std::vector<std::string_view> modules{};  // in the order of the descriptor
    std::set<std::string_view> sorted{};
  };

  void add(Line line, std::string what, std::string fix) {
    findings_.add(line, std::move(what), std::move(fix));
  }
  [[nodiscard]] bool full() const { return findings_.full(); }
  /// Returns the DDS domain of a connection's topic.
  [[nodiscard]] int domain_of(const Connection& connection) const {
    return connection.domain.value_or(cell_.domain);
  }
  void check_peers();
  void check_server();
  void check_connection(const Connection& connection);
  void check_topic(const Connection& connection);
  void check_ros2_topic(const Connection& connection);
  bool check_ends(const Connection& connection);
  bool check_endpoint(const Endpoint& endpoint, const char* side, Line line);
  bool check_service_end(const Endpoint& end, const char* side, Line line);
  void check_writers(const Connections& connections);
  void check_waiting(const Connections& connections);
  void check_shared_topics(const Connections& connections);

  const Cell& cell_;
  const Gaps& gaps_;
  Findings& findings_;
  std::map<std::string_view, Known> devices_;
};

void Network::check_discovery() {
  if (gaps_.discovery) return;
  check_peers();
  check_server();
  if (cell_.security_required && cell_.discovery.kind == Discovery::Kind::server) {
    add(cell_.line,
        "security=\"required\" cannot be used with a discovery server in this version of Fast DDS",
        "set discovery=\"multicast\" or \"peers\", or security=\"optional\"");
  }
}

void Network::check_peers() {
  using Kind = Discovery::Kind;
  const Discovery& discovery = cell_.discovery;
  if (discovery.kind != Kind::peers && !discovery.peers.empty()) {
    add(cell_.line, "the cell has peers but not discovery=\"peers\"",
        "set discovery=\"peers\", or remove peers");
  }
  if (discovery.kind == Kind::peers && discovery.peers.empty()) {
    add(cell_.line, "discovery=\"peers\" requires peers",
        "name at least one, as in peers=\"10.0.0.1 line.local\"");
  }
  if (discovery.peers.size() > kMaxPeers) {
    add(cell_.line, "the cell has more than 256 peers", "use a discovery server instead");
    return;
  }
  std::set<std::string_view> seen;
  for (const std::string& peer : discovery.peers) {
    if (!is_valid_host(peer)) {
      add(cell_.line, in_quotes(peer) + " is not a valid peer",
          "a peer is an IPv4 address or a host name, without a port; separate peers with spaces");
    } else if (!seen.insert(peer).second) {
      add(cell_.line, "duplicate peer " + in_quotes(peer), "list each peer only once");
    }
  }
}

void Network::check_server() {
  using Kind = Discovery::Kind;
  const Discovery& discovery = cell_.discovery;
  if (discovery.kind == Kind::server && discovery.server.empty()) {
    add(cell_.line, "discovery=\"server\" requires a server",
        "give its address, as in server=\"10.0.0.1:11811\"");
  }
  if (!discovery.server.empty()) {
    if (!is_valid_server(discovery.server)) {
      add(cell_.line, in_quotes(discovery.server) + " is not a valid discovery server",
          "write host:port, as in 10.0.0.1:11811");
    }
    if (discovery.kind != Kind::server) {
      add(cell_.line, "the cell has a server but not discovery=\"server\"",
          "set discovery=\"server\", or remove the server");
    }
  }
  if (cell_.server_device.empty()) return;
  if (discovery.kind != Kind::server) {
    add(cell_.line, "the cell has a server-device but not discovery=\"server\"",
        "set discovery=\"server\", or remove the server-device");
  }
  const std::vector<std::string_view> names = names_of(cell_.devices);
  if (gaps_.devices || std::find(names.begin(), names.end(), cell_.server_device) != names.end()) return;
  add(cell_.line, "attribute 'server-device' names the unknown device " + in_quotes(cell_.server_device),
      choose("device", cell_.server_device, names));
}

/// Checks one end of a connection or service. Returns false if the end is invalid; the caller then does not
/// compare this connection with others.
bool Network::check_endpoint(const Endpoint& endpoint, const char* side, Line line) {
  if (!is_valid_name(endpoint.device) || !is_valid_name(endpoint.module) || !is_valid_name(endpoint.port)) {
    add(line, "attribute " + in_quotes(side) + " is not valid: " + in_quotes(to_text(endpoint)),
        std::string{side == std::string_view{"client"} || side == std::string_view{"server"}
                        ? "write device.module.service; "
                        : "write device.module.port; "} +
            kNameRule);
    return false;
  }
  const auto found = devices_.find(endpoint.device);
  if (found == devices_.end()) {
    if (gaps_.devices) return true;
    add(line, "attribute " + in_quotes(side) + " names the unknown device " + in_quotes(endpoint.device),
        choose("device", endpoint.device, names_of(cell_.devices)));
    return false;
  }
  const Known& known = found->second;
  if (known.sorted.count(endpoint.module) > 0 || known.gaps) return true;
  std::string fix = choose("module", endpoint.module, known.modules);
  const std::string_view meant = nearest(endpoint.module, known.modules);
  for (const Device& device : cell_.devices) {
    if (meant.empty() || device.name != endpoint.device) continue;
    for (const Module& module : device.modules) {
      if (module.name == meant && !module.lines.name.given())
        fix += " The module " + findings_.whereabouts(module.line) + " has this name from its <filename>";
    }
  }
  add(line,
      "attribute " + in_quotes(side) + " names the unknown module " + in_quotes(endpoint.module) +
          " of device " + in_quotes(endpoint.device),
      std::move(fix));
  return false;
}

void Network::check_connection(const Connection& connection) {
  if (connection.kind == ConnectionKind::latest && connection.depth != 1) {
    add(connection.line, "a connection of kind latest has a depth", "remove depth, or set kind=\"queue\"");
  } else if (connection.depth < 1 || connection.depth > kMaxDepth) {
    add(connection.line, "a connection has depth " + std::to_string(connection.depth),
        "depth must be from 1 to 65536");
  }
  const auto positive = [&](const char* what, const std::optional<Nanoseconds>& time) {
    if (!time || time->count() > 0) return;
    add(connection.line,
        std::string{"a connection has a "} + what + " of " + std::to_string(time->count()) + " ns",
        std::string{"a "} + what + " must be at least 1 ns");
  };
  positive("deadline", connection.deadline);
  positive("lifespan", connection.lifespan);
  if (connection.stale == Stale::error && !connection.deadline) {
    add(connection.line, "a connection has stale=\"error\" but no deadline",
        "add deadline, the age at which a value becomes stale");
  }
  check_topic(connection);
}

void Network::check_topic(const Connection& connection) {
  const std::string& topic = connection.topic;
  if (!topic.empty() && !is_valid_topic(topic)) {
    add(connection.line, in_quotes(topic) + " is not a valid topic", kTopicRule);
  } else if (topic.rfind(kOwnTopics, 0) == 0) {
    add(connection.line, "the topic " + in_quotes(topic) + " begins with takt/, which is reserved for Takt",
        "choose another name, or remove topic: the connection then gets a topic of its own");
  }
  if (connection.ros2) check_ros2_topic(connection);
  if (!connection.domain) return;
  if (*connection.domain < 0 || *connection.domain > kMaxDomain) {
    add(connection.line, "a connection has domain " + std::to_string(*connection.domain),
        "a domain must be from 0 to 232");
  }
  if (topic.empty()) {
    add(connection.line, "a connection has a domain but no topic",
        "the domain applies to the topic: add a topic, or remove the domain");
  }
}

void Network::check_ros2_topic(const Connection& connection) {
  constexpr const char* kRule =
      "a ROS 2 topic name consists of words separated by /, as in /arm/joint_states; a word has letters, "
      "digits and _, and "
      "does not begin with a digit";
  const std::string_view prefix = kRos2Topics;
  const std::string& topic = connection.topic;
  if (topic.empty()) {
    add(connection.line, "a connection has ros2=\"true\" but no topic", "name the ROS 2 topic");
  } else if (topic.rfind(prefix, 0) != 0) {
    add(connection.line, in_quotes(topic) + " is not a valid ROS 2 topic", kRule);
  } else if (!is_ros2_name(std::string_view{topic}.substr(prefix.size()))) {
    add(connection.line, in_quotes(topic.substr(prefix.size())) + " is not a valid ROS 2 topic", kRule);
  }
}

/// Checks both ends of a connection. Returns false if one of them is wrong, so that the connection cannot be
/// compared with other connections.
bool Network::check_ends(const Connection& connection) {
  const bool from_missing = is_missing(connection.from);
  const bool to_missing = is_missing(connection.to);
  if (from_missing && to_missing) {
    add(connection.line, "a connection has neither attribute 'from' nor attribute 'to'",
        "name both ports, or one port and a topic");
    return false;
  }
  const bool from_known = from_missing || check_endpoint(connection.from, "from", connection.line);
  const bool to_known = to_missing || check_endpoint(connection.to, "to", connection.line);
  if (connection.topic.empty() && (from_missing || to_missing)) {
    add(connection.line, std::string{"a connection has no attribute "} + (from_missing ? "'from'" : "'to'"),
        from_missing ? "set from=\"...\" to the port that sends the samples, or topic=\"...\" to a topic "
                       "that another program writes"
                     : "set to=\"...\" to the port that receives the samples, or topic=\"...\" to a topic "
                       "that another program reads");
    return false;
  }
  if (to_missing && connection.stale == Stale::error) {
    add(connection.line, "a connection has stale=\"error\" but no attribute 'to'",
        "remove stale: no module of this cell reads the value");
  }
  if (!from_known || !to_known) return false;
  if (from_missing || to_missing) return true;

  if (key(connection.from) == key(connection.to)) {
    add(connection.line, "the port " + in_quotes(to_text(connection.from)) + " is connected to itself",
        "connect an output of one module to an input of another");
    return false;
  }
  const std::size_t length = topic_of(cell_, connection).size();
  if (connection.from.device != connection.to.device && length > kMaxTopic) {
    add(connection.line,
        "the name of the topic from " + in_quotes(to_text(connection.from)) + " would have " +
            std::to_string(length) + " characters",
        "a topic name has at most 255 characters: use shorter names, or set topic on the connection");
  }
  return true;
}

/// Checks that no connection is written twice, and that each input that holds one latest value has only one
/// writer.
void Network::check_writers(const Connections& connections) {
  // The key of a connection. Connections between the same two ports are duplicates even if their topics
  // differ.
  using Same = std::tuple<Key, Key, std::string_view, int>;
  std::map<Same, const Connection*> same;
  std::map<Key, const Connection*> writer;
  for (const Connection* connection : connections) {
    if (full()) return;
    const bool both = !is_missing(connection->from) && !is_missing(connection->to);
    const Same ends{key(connection->from), key(connection->to),
                    both ? std::string_view{} : std::string_view{connection->topic},
                    both ? 0 : domain_of(*connection)};
    const auto [twin, is_new] = same.emplace(ends, connection);
    if (!is_new) {
      const auto named = [](const char* side, const Endpoint& end) {
        return is_missing(end) ? std::string{} : std::string{side} + in_quotes(to_text(end));
      };
      add(connection->line,
          "duplicate connection" + named(" from ", connection->from) + named(" to ", connection->to) +
              (both ? "" : ", topic " + in_quotes(connection->topic)),
          "remove this one; the first is " + findings_.whereabouts(twin->second->line));
      continue;
    }
    if (is_missing(connection->to)) continue;
    const auto [other, is_first] = writer.emplace(key(connection->to), connection);
    if (is_first) continue;
    const bool both_queues =
        connection->kind == ConnectionKind::queue && other->second->kind == ConnectionKind::queue;
    if (both_queues) continue;
    add(connection->line,
        "two writers of " + in_quotes(to_text(connection->to)) + ", which holds one latest value",
        "remove one, or set kind=\"queue\" on every connection to this port; the first is " +
            findings_.whereabouts(other->second->line));
  }
}

/// Checks that each topic that is read as a latest value has only one writer, because a reader of a topic
/// receives the samples of all its writers.
void Network::check_shared_topics(const Connections& connections) {
  struct Writers {
    const Connection* first = nullptr;
    // The first connection whose writer is a port other than that of `first`.
    const Connection* other = nullptr;
  };
  std::map<std::pair<std::string_view, int>, Writers> topics;
  const auto topic_of = [&](const Connection& connection) {
    return std::pair{std::string_view{connection.topic}, domain_of(connection)};
  };
  for (const Connection* connection : connections) {
    if (connection->topic.empty() || is_missing(connection->from)) continue;
    Writers& writers = topics[topic_of(*connection)];
    if (writers.first == nullptr) {
      writers.first = connection;
    } else if (writers.other == nullptr && key(writers.first->from) != key(connection->from)) {
      writers.other = connection;
    }
  }
  for (const Connection* connection : connections) {
    if (full()) return;
    if (connection->topic.empty() || is_missing(connection->to)) continue;
    if (connection->kind != ConnectionKind::latest) continue;
    const auto found = topics.find(topic_of(*connection));
    if (found == topics.end() || found->second.other == nullptr) continue;
    const Writers& writers = found->second;
    add(connection->line,
        "two writers of " + in_quotes(to_text(connection->to)) +
            ", which holds one latest value: " + in_quotes(to_text(writers.first->from)) + " and " +
            in_quotes(to_text(writers.other->from)) + " both write the topic " + in_quotes(connection->topic),
        "give one of them another topic, or set kind=\"queue\" on this connection");
  }
}

/// Finds cycles of connections with stale="error". A module in error writes no samples. If each module of a
/// cycle is in error because it waits for a value of the next module, none of them can recover.
void Network::check_waiting(const Connections& connections) {
  using Name = std::pair<std::string_view, std::string_view>;
  struct Reader {
    std::vector<const Connection*> waits_for;
    std::size_t next = 0;  // index in waits_for of the next connection to follow
    bool entered = false;
    bool left = false;
  };
  const auto name_of = [](const Endpoint& end) { return Name{end.device, end.module}; };
  std::map<Name, Reader> readers;
  for (const Connection* connection : connections) {
    if (connection->stale != Stale::error || is_missing(connection->from) || is_missing(connection->to))
      continue;
    readers[name_of(connection->to)].waits_for.push_back(connection);
  }
  for (auto& [first, start] : readers) {
    if (start.entered) continue;
    std::vector<std::pair<Name, Reader*>> path{{first, &start}};
    start.entered = true;
    while (!path.empty() && !full()) {
      Reader& reader = *path.back().second;
      if (reader.next == reader.waits_for.size()) {
        reader.left = true;
        path.pop_back();
        continue;
      }
      const Connection& connection = *reader.waits_for[reader.next++];
      const auto writer = readers.find(name_of(connection.from));
      if (writer == readers.end() || writer->second.left) continue;
      if (!writer->second.entered) {
        writer->second.entered = true;
        path.emplace_back(writer->first, &writer->second);
        continue;
      }
      const auto begin = std::find_if(path.begin(), path.end(),
                                      [&](const auto& each) { return each.first == writer->first; });
      std::string circle;
      for (auto each = begin; each != path.end(); ++each)
        circle += (circle.empty() ? "" : ", ") + std::string{each->first.first} + "." +
                  std::string{each->first.second};
      add(connection.line,
          path.end() - begin == 1
              ? "module " + circle +
                    " waits for a value that it writes itself: once in error, it can never recover"
              : "modules " + circle +
                    " wait for each other's values in a cycle: once they are in error, none of them can "
                    "recover",
          "remove stale=\"error\" from one of these connections");
    }
  }
}

void Network::check_connections() {
  if (cell_.connections.size() > kMaxConnections) {
    add(cell_.line, "the cell has more than 100000 connections", "split it into several cells");
    return;
  }
  for (std::size_t i = 0; i < cell_.devices.size(); ++i) {
    Known& known = devices_[cell_.devices[i].name];
    known.gaps = known.gaps || gaps_.of_device[i].modules;
    for (const Module& module : cell_.devices[i].modules) {
      if (known.sorted.insert(module.name).second) known.modules.emplace_back(module.name);
    }
  }
  Connections comparable;
  for (std::size_t index = 0; index < cell_.connections.size() && !full(); ++index) {
    const Connection& connection = cell_.connections[index];
    if (connection.carries != Carries::samples)
      continue;  // this connection belongs to a service; check_services() checks it
    check_connection(connection);
    if (index < gaps_.without_ends.size() && gaps_.without_ends[index]) continue;
    if (check_ends(connection)) comparable.push_back(&connection);
  }
  check_writers(comparable);
  check_shared_topics(comparable);
  check_waiting(comparable);
}

bool Network::check_service_end(const Endpoint& end, const char* side, Line line) {
  if (!check_endpoint(end, side, line)) return false;
  if (end.port.size() <= kMaxServiceName) return true;
  add(line, "attribute " + in_quotes(side) + " names " + in_quotes(end.port) + ", which is too long",
      "the name of a service or client may have at most " + std::to_string(kMaxServiceName) + " characters");
  return false;
}

/// Checks the services. A client must have only one server; a service may have many clients.
void Network::check_services() {
  if (cell_.services.size() > kMaxConnections) {
    add(cell_.line, "the cell has more than 100000 services", "split it into several cells");
    return;
  }
  std::map<Key, const Service*> served;
  for (std::size_t index = 0; index < cell_.services.size() && !full(); ++index) {
    const Service& service = cell_.services[index];
    if (index < gaps_.without_sides.size() && gaps_.without_sides[index]) continue;
    const bool client_known = check_service_end(service.client, "client", service.line);
    const bool server_known = check_service_end(service.server, "server", service.line);
    if (!client_known || !server_known) continue;
    if (service.client.device == service.server.device && service.client.module == service.server.module) {
      add(service.line,
          "module " + in_quotes(service.client.device + "." + service.client.module) +
              " is both client and server of a service",
          "call a function instead: a service connects two modules");
      continue;
    }
    const auto [other, is_first] = served.emplace(key(service.client), &service);
    if (!is_first) {
      const bool same = key(other->second->server) == key(service.server);
      add(service.line,
          same ? "duplicate <service> for client " + in_quotes(to_text(service.client))
               : "client " + in_quotes(to_text(service.client)) + " has two servers",
          "remove one; the first is " + findings_.whereabouts(other->second->line));
      continue;
    }
    // Both topics are named after the client, and the name of the request topic is longer than that of the
    // reply topic. So if the request topic is not too long, the reply topic is not too long either.
    Endpoint request = service.client;
    request.port += kRequestPort;
    const Connection requests{
        .from = request, .to = {}, .deadline = {}, .lifespan = {}, .topic = {}, .domain = {}};
    const std::size_t length = topic_of(cell_, requests).size();
    if (service.client.device != service.server.device && length > kMaxTopic) {
      add(service.line,
          "the name of the topic of client " + in_quotes(to_text(service.client)) + " would have " +
              std::to_string(length) + " characters",
          "a topic name has at most 255 characters: use shorter names");
    }
  }
}

}  // namespace

void validate_network(const Cell& cell, const Gaps& gaps, Findings& findings) {
  Network network{cell, gaps, findings};
  network.check_discovery();
  network.check_connections();
  network.check_services();
}

}  // namespace takt::model
