#include <takt/dds/participant.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <mutex>
#include <sstream>
#include <utility>

#include <takt/core/check.hpp>
#include <takt/core/words.hpp>
#include <takt/model/validate.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/network.hpp>
#include <takt/os/notice.hpp>
#include <takt/os/real_time.hpp>
#include <takt/os/signals.hpp>
#include "discovery_listener.hpp"
#include "inside.hpp"
#include "log.hpp"
#include "workarounds/deferred_timers.hpp"
#include "workarounds/heartbeats.hpp"
#include "workarounds/leases.hpp"
#include "workarounds/message_size.hpp"
#include "workarounds/own_announcement.hpp"
#include "workarounds/participant_removal.hpp"
#include "workarounds/peer_certificates.hpp"
#include "workarounds/reader_checks.hpp"
#include "workarounds/removed_readers.hpp"
#include "workarounds/resends.hpp"
#include "workarounds/returning_readers.hpp"
#include "workarounds/second_announcement.hpp"
#include "workarounds/soon_repeated.hpp"
#include "workarounds/spent_tokens.hpp"
#include "workarounds/unmatched_writers.hpp"

namespace takt::dds {

namespace {

constexpr const char* kServerPrefix =
    "44.53.00.5f.45.50.52.4f.53.49.4d.41";  // the GUID prefix that the manual of Fast DDS gives to the first
                                            // discovery server
/// Other participants forget this one if they hear nothing of it for this time.
constexpr Nanoseconds kParticipantLease = std::chrono::seconds{3};
constexpr Nanoseconds kAnnounceEvery = std::chrono::seconds{1};
constexpr int kFollowEveryMs = 250;
/// After a halt of this time, other participants may have forgotten this one.
constexpr Nanoseconds kHalted =
    kParticipantLease - kAnnounceEvery - std::chrono::milliseconds{kFollowEveryMs};
/// See Participant::Announced. Fast DDS repeats a discovery message at least once in a second, even on a slow
/// link.
constexpr Nanoseconds kSendsMore = std::chrono::milliseconds{1500};
/// After the first notice of a change of the interfaces, wait for more: a change often takes several steps.
constexpr int kMoreNewsMs = 100;
/// The time in which most name services answer. Then the first announcements reach the peers.
constexpr Nanoseconds kNamesAnswer = std::chrono::milliseconds{200};
/// The number of file descriptors that must be free before a participant is created. A participant needs
/// fewer on a machine with a few networks. If Fast DDS runs out of file descriptors, it ends the process.
constexpr std::size_t kDescriptors = 48;

std::atomic<bool> there_is_one{false};

rtps::Locator_t locator(const os::Ipv4& address, std::uint32_t port) {
  rtps::Locator_t locator;
  locator.kind = LOCATOR_KIND_UDPv4;
  rtps::IPLocator::setIPv4(locator, address[0], address[1], address[2], address[3]);
  locator.port = port;
  return locator;
}

/// Sets how the participant finds others. Adds the names of other machines to `names`.
Result<void> set_discovery(fast::DomainParticipantQos& qos, const model::Discovery& discovery,
                           std::uint32_t domain, const Interfaces& interfaces, PacketFilter& filter,
                           const std::shared_ptr<HostNames>& names) {
  auto& builtin = qos.wire_protocol().builtin;
  auto& config = builtin.discovery_config;
  config.leaseDuration = duration(kParticipantLease);
  // Each message, not only an announcement, shows that a participant exists.
  config.leaseDuration_announcementperiod = duration(kAnnounceEvery);
  // The first announcements can be lost if two participants start at the same time. Each pause between them
  // is twice as long as the one before (own_announcement.cpp).
  config.initial_announcements.count = kFirstAnnouncements;
  config.initial_announcements.period = duration(kFirstPause);
  switch (discovery.kind) {
    case model::Discovery::Kind::multicast:
      break;
    case model::Discovery::Kind::peers:
      for (const std::string& peer : discovery.peers) {
        if (!model::is_valid_host(peer))
          return fail(in_quotes(peer) + " is not a valid peer",
                      "a peer is an IPv4 address or a host name, without a port");
        builtin.initialPeersList.push_back(locator(names->add("peer", peer), 0));
      }
      // Interfaces keeps this group on the machine.
      builtin.initialPeersList.push_back(locator(kGroup, qos.wire_protocol().port.getMulticastPort(domain)));
      break;
    case model::Discovery::Kind::server: {
      if (!model::is_valid_server(discovery.server))
        return fail(in_quotes(discovery.server) + " is not a valid discovery server",
                    "write host:port, as in 10.0.0.1:11811");
      const std::size_t colon = discovery.server.rfind(':');
      const std::string host = discovery.server.substr(0, colon);
      const auto port = static_cast<std::uint32_t>(std::stoul(discovery.server.substr(colon + 1)));
      if (discovery.serve) {
        config.discoveryProtocol = rtps::DiscoveryProtocol::SERVER;
        std::istringstream{kServerPrefix} >> qos.wire_protocol().prefix;
        // A server with a name announces all addresses of its machine, like other participants. Fast DDS
        // finds other ones than Interfaces does, and rejects the difference.
        const auto given = os::from_dots(host);
        const bool all = !given || *given == os::Ipv4{};
        for (const os::Ipv4& each : all ? interfaces.announced() : std::vector{*given})
          builtin.metatrafficUnicastLocatorList.push_back(locator(each, port));
      } else {
        rtps::GuidPrefix_t prefix;
        std::istringstream{kServerPrefix} >> prefix;
        const os::Ipv4 address = names->add_server(host);
        use_server(config, prefix, locator(address, port));
        filter.follow({.number = number_in(prefix),
                       .placeholder = address,
                       .port = static_cast<std::uint16_t>(port),
                       .announced = [names, address](const std::vector<os::Ipv4>& addresses) {
                         names->announced(address, addresses);
                       }});
      }
      break;
    }
  }
  return {};
}

/// Reads the addresses of this machine. Fails if it has not one of those in `only`.
Result<std::shared_ptr<Interfaces>> find_interfaces(const std::vector<std::string>& only,
                                                    model::Discovery::Kind discovery) {
  const auto addresses = os::interface_addresses();
  if (!addresses) return addresses.problems();
  Interfaces::Options options{.only = {},
                              .groups_stay_here = discovery == model::Discovery::Kind::peers,
                              .has_server = discovery == model::Discovery::Kind::server};
  std::string known;
  for (const os::InterfaceAddress& each : *addresses) {
    if (each.connected) known += (known.empty() ? "" : ", ") + os::in_dots(each.address);
  }
  for (const std::string& name : only) {
    const auto found =
        std::find_if(addresses->begin(), addresses->end(), [&](const os::InterfaceAddress& each) {
          return each.connected && os::in_dots(each.address) == name;
        });
    if (found == addresses->end()) {
      return fail("this machine has no interface with the address '" + name + "'",
                  known.empty() ? "no network interface is up"
                                : "set TAKT_INTERFACE to one of its addresses: " + known);
    }
    options.only.push_back(found->address);
  }
  auto interfaces = std::make_shared<Interfaces>(std::move(options));
  interfaces->update(*addresses);
  interfaces->settle();
  return interfaces;
}

/// Reads the identity from the folder `options.security`. Fails if the identity is damaged or not valid for
/// `options.domain`.
Result<security::Identity> identity_for(const ParticipantOptions& options) {
  if (options.discovery.kind == model::Discovery::Kind::server) {
    return fail("DDS Security and a discovery server exclude each other in this version of Fast DDS",
                "use multicast or --peers instead of the server");
  }
  auto identity = security::read_identity(options.security, os::wall_ns() / 1'000'000'000);
  if (!identity) return identity;
  const std::vector<int>& domains = identity->domains;
  if (std::find(domains.begin(), domains.end(), options.domain) != domains.end()) return identity;
  if (domains.empty()) {
    return Problem{options.security, "this identity may not read or write any topic of its cell",
                   "add a connection with only one end to the cell; programs may use its topic"};
  }
  std::string known;
  for (const int domain : domains) known += (known.empty() ? "" : ", ") + std::to_string(domain);
  return Problem{
      options.security,
      "this identity is for domain " + known + ", not for domain " + std::to_string(options.domain),
      "use domain " + known + ", or run takt secure update --domain " + std::to_string(options.domain)};
}

void set_security(fast::DomainParticipantQos& qos, const security::Identity& identity) {
  auto& properties = qos.properties().properties();
  const auto file = [&](const std::string& property, const char* name) {
    properties.emplace_back(property, "file://" + identity.folder + "/" + name);
  };
  const std::string identity_plugin = "dds.sec.auth.builtin.PKI-DH.";
  properties.emplace_back("dds.sec.auth.plugin", "builtin.PKI-DH");
  file(identity_plugin + "identity_ca", security::kIdentityAuthority);
  file(identity_plugin + "identity_certificate", security::kCertificate);
  file(identity_plugin + "private_key", security::kPrivateKey);
  file(identity_plugin + "identity_crl", security::kRevoked);
  // Fast DDS 3 would send an authentication message ten times, more and more slowly, and then report that it
  // rejects the other participant, which may only have ended. Version 2.9 sends it until it is answered
  // (soon_repeated.hpp).
  properties.emplace_back(identity_plugin + "initial_handshake_resend_period", "200");  // ms
  properties.emplace_back(identity_plugin + "handshake_resend_period_gain", "1");
  properties.emplace_back(identity_plugin + "max_handshake_requests", "2147483647");
  const std::string access_plugin = "dds.sec.access.builtin.Access-Permissions.";
  properties.emplace_back("dds.sec.access.plugin", "builtin.Access-Permissions");
  file(access_plugin + "permissions_ca", security::kAccessAuthority);
  file(access_plugin + "governance", security::kGovernance);
  file(access_plugin + "permissions", security::kPermissions);
  properties.emplace_back("dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC");
  // Members with Fast DDS 2.9 know only its own names of algorithms; those with Fast DDS 3 know both.
  for (const std::string& plugin : {identity_plugin, access_plugin})
    properties.emplace_back(plugin + "transmit_algorithms_as_legacy", "true");
}

}  // namespace

Result<std::shared_ptr<Participant>> Participant::create(const ParticipantOptions& options) {
  if (options.domain < 0 || options.domain > 232)
    return fail("DDS domain " + std::to_string(options.domain) + " does not exist", "use 0 to 232");
  if (os::is_real_time()) {
    return fail(
        "a DDS participant cannot be created on a real-time thread: its threads would be real-time too",
        "create it before the thread becomes real-time, or on another thread");
  }
  if (there_is_one.exchange(true))
    return fail("this process has a DDS participant already", "use the existing participant");
  const auto refuse = [](Problems problems) {
    there_is_one = false;
    return problems;
  };
  auto interfaces = find_interfaces(options.interfaces, options.discovery.kind);
  if (!interfaces) return refuse(interfaces.problems());
  auto news = os::InterfaceNews::open();
  if (!news) return refuse(news.problems());
  auto ending = os::Notice::create();
  if (!ending) return refuse(ending.problems());
  if (auto room = os::can_open(kDescriptors); !room) return refuse(room.problems());
  check_what_readers_receive();
  lock_readers_that_lose_writers();
  remove_readers_without_deadlock();
  send_again_to_returning_readers();
  repeat_lost_messages_soon();
  prepare_own_announcement(options.security.empty(), options.discovery.serve);
  prepare_heartbeats();
  renew_leases_quietly();
  defer_deletion_of_timers();
  keep_messages_short(!options.security.empty());
  log_to_standard_error();
  turn_off_intraprocess_delivery();

  fast::DomainParticipantQos qos;
  qos.name(options.name.c_str());
  // Fast DDS would announce the names of the machine, the user and the process.
  qos.properties().properties().clear();
  // All readers and writers know their types. Fast DDS 2.9 sends no descriptions of them unless it is told
  // to.
  qos.properties().properties().emplace_back("fastdds.type_propagation", "disabled");
  const auto names = std::make_shared<HostNames>(os::look_up, options.told);
  auto notices = std::make_unique<wire::Notices>(options.refused);
  auto filter = std::make_shared<PacketFilter>(*notices, !options.security.empty());
  if (auto set = set_discovery(qos, options.discovery, static_cast<std::uint32_t>(options.domain),
                               **interfaces, *filter, names);
      !set)
    return refuse(set.problems());
  // Without DDS Security, a discovery message for several participants is sent once, to the multicast group.
  qos.wire_protocol().builtin.avoid_builtin_multicast = !options.security.empty();
  pause_during_removals(filter->receive_lock);
  auto unreached = std::make_unique<wire::Notices>(options.unreached);
  limit_resends([to = unreached.get()](const std::string& text) { to->tell(text); });
  const auto transport = std::make_shared<UdpTransportDescriptor>(
      *interfaces, filter, std::make_shared<UdpChannels>(*interfaces), names);
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(transport);

  std::unique_ptr<KnownParticipants> others;
  DiscoveryListener* secured = nullptr;
  if (!options.security.empty()) {
    auto identity = identity_for(options);
    if (!identity) return refuse(identity.problems());
    set_security(qos, *identity);
    drop_spent_tokens();
    auto listener = std::make_unique<DiscoveryListener>(std::move(*identity), *notices, *filter);
    secured = listener.get();
    others = std::move(listener);
    prepare_for_old_members();
    filter->look_at_announcements([secured](const wire::Announcement& announcement, const os::Ipv4& from) {
      note_member(announcement.number, !announcement.has_version);
      secured->announced(announcement, from);
    });
    look_at_certificates([secured](const rtps::GuidPrefix_t& peer, const x509_st& certificate) {
      secured->certified(peer, certificate);
    });
  } else {
    others = std::make_unique<KnownParticipants>();
  }

  names->step(os::now());
  names->wait(kNamesAnswer);
  // Fast DDS reads settings for other programs from the environment, and from files that it names or that are
  // in the working folder.
  const os::ChangedEnvironment without_settings{{"FASTDDS_", "FASTRTPS_", "ROS"}, "SKIP_DEFAULT_XML_FILE=1"};
  auto* factory = fast::DomainParticipantFactory::get_instance();
  fast::DomainParticipant* made = factory->create_participant(static_cast<fast::DomainId_t>(options.domain),
                                                              qos, others.get(), fast::StatusMask::none());
  if (made == nullptr) {
    return refuse({fail("DDS cannot be used on domain " + std::to_string(options.domain),
                        "see the message that DDS printed; the processes of this domain use UDP ports from " +
                            std::to_string(7400 + 250 * options.domain) +
                            " upwards, enough for about 120 processes on one machine")});
  }
  fast::Publisher* publisher = made->create_publisher(fast::PUBLISHER_QOS_DEFAULT);
  fast::Subscriber* subscriber = made->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
  std::shared_ptr<Participant> participant = std::make_shared<OwnParticipant>(
      made, publisher, subscriber, std::move(notices), std::move(unreached), std::move(others), secured,
      *transport, names, std::move(*news), std::move(*ending),
      !options.security.empty() || options.discovery.kind == model::Discovery::Kind::peers);
  if (publisher == nullptr || subscriber == nullptr)
    return fail("DDS could not create a publisher and a subscriber", "see the message that DDS printed");
  return participant;
}

OwnParticipant::OwnParticipant(fast::DomainParticipant* participant, fast::Publisher* publisher,
                               fast::Subscriber* subscriber, std::unique_ptr<wire::Notices> notices,
                               std::unique_ptr<wire::Notices> unreached,
                               std::unique_ptr<KnownParticipants> others, DiscoveryListener* secured,
                               const UdpTransportDescriptor& transport, std::shared_ptr<HostNames> names,
                               os::InterfaceNews news, os::Notice ending, bool must_rejoin)
    : notices_(std::move(notices)),
      unreached_(std::move(unreached)),
      others_(std::move(others)),
      discovery_listener_(secured),
      interfaces_(transport.interfaces()),
      filter_(transport.filter()),
      channels_(transport.channels()),
      names_(std::move(names)),
      participant_(participant),
      publisher_(publisher),
      subscriber_(subscriber),
      news_(std::move(news)),
      ending_(std::move(ending)),
      must_rejoin_(must_rejoin) {
  if (discovery_listener_ != nullptr) {
    identity_ = discovery_listener_->mine();
    look_at_log([secured](const std::string& message) { return secured->look(message); });
    filter_->take_loss_reports(number_in(participant_->guid().guidPrefix),
                               [secured](const wire::ParticipantNumber& by, std::optional<Instant> heard) {
                                 secured->losses.reported(by, heard, os::now());
                               });
  }
  machine_ = std::jthread{[this](std::stop_token end) { follow_machine(std::move(end)); }};
}

std::string OwnParticipant::obstacle(const std::string& device) const {
  const std::lock_guard lock{mutex_};
  const auto found = devices_.find(device);
  return found == devices_.end() ? std::string{} : obstacle_to(found->second);
}

std::vector<Participant::Announced> OwnParticipant::announced() const {
  std::vector<Announced> all;
  for (const auto& [number, name] : others_->names()) {
    const auto last = filter_->last_message_of(number);
    all.push_back({name, last && os::now() - *last < kSendsMore});
  }
  return all;
}

std::string OwnParticipant::rejection_of(const std::string& device) const {
  return discovery_listener_ == nullptr ? std::string{} : discovery_listener_->rejection_of(device);
}

void OwnParticipant::is_device(const rtps::GuidPrefix_t& participant, const std::string& device) {
  const std::lock_guard lock{mutex_};
  std::copy_n(participant.value, wire::ParticipantNumber{}.size(), devices_[device].begin());
}

void OwnParticipant::follow_machine(std::stop_token end) {
  const std::stop_callback wake{end, [this] { ending_.give(); }};
  for (Instant last = os::boot_time(); !end.stop_requested();) {
    os::wait_readable({&news_.fd(), &ending_.fd()}, kFollowEveryMs);
    // The process was halted, or its machine was suspended.
    const bool was_halted = os::boot_time() - last > kHalted;
    if (end.stop_requested()) return;
    names_->step(os::now());
    if (discovery_listener_ != nullptr) {
      discovery_listener_->check_certificates(os::wall_ns() / 1'000'000'000);
      follow_losses();
    }
    if (was_halted && identity_) rejoin(*filter_, others_->names(), true);
    if (news_.take()) {
      while (os::wait_readable({&news_.fd()}, kMoreNewsMs)) news_.take();
      follow_interfaces();
    }
    last = os::boot_time();
  }
}

void OwnParticipant::follow_losses() {
  LossReports& losses = discovery_listener_->losses;
  for (const auto& [participant, at] : losses.due(os::now()))
    filter_->send(wire::loss_report(number_in(participant_->guid().guidPrefix), participant), at);
  for (const wire::ParticipantNumber& participant : losses.take_mutual()) forget(participant);
  for (const wire::ParticipantNumber& participant : filter_->unauthenticated.remove_expired())
    forget_silent(participant);
}

void OwnParticipant::follow_interfaces() {
  const auto addresses = os::interface_addresses();
  if (!addresses) return;
  const Interfaces::Change change = interfaces_->update(*addresses);
  if (!change.any) return;
  const std::vector<os::Ipv4> announced = interfaces_->announced();
  announce_addresses(*participant_, announced);
  announce_endpoints();
  interfaces_->settle();
  channels_->follow_interfaces();
  // While this participant has no address, other machines cannot hear where it is, nor that it leaves.
  const bool is_heard = announced.front() != os::kLoopbackAddress;
  if (must_rejoin_ && is_heard && (change.removed_used || (has_moved_ && change.added)))
    rejoin(*filter_, others_->names(), false);
  else
    announce_again();
  has_moved_ = change.removed_used || (has_moved_ && !change.added);
}

void OwnParticipant::announce_endpoints() {
  const std::lock_guard lock{endpoints_};
  std::vector<fast::DataWriter*> writers;
  publisher_->get_datawriters(writers);
  for (fast::DataWriter* each : writers) each->set_qos(each->get_qos());
  std::vector<fast::DataReader*> readers;
  subscriber_->get_datareaders(readers);
  for (fast::DataReader* each : readers) each->set_qos(each->get_qos());
}

OwnParticipant::~OwnParticipant() {
  machine_ = {};  // ends the thread
  look_at_log(nullptr);
  participant_->delete_contained_entities();
  fast::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  if (discovery_listener_ != nullptr) look_at_certificates(nullptr);
  there_is_one = false;
}

Result<fast::Topic*> OwnParticipant::topic(const std::string& name, const fast::TypeSupport& type) {
  const std::lock_guard lock{mutex_};
  const std::string& type_name = type.get_type_name();
  const fast::TopicDataType& decoder = *type;
  if (const auto found = types_.find(type_name);
      found != types_.end() &&
      (found->second.size != max_size_of(decoder) || found->second.decoder != typeid(decoder))) {
    return fail("there are two different types named '" + type_name + "' in this process",
                "build all components with the same version of the type");
  }
  if (const auto found = topics_.find(name); found != topics_.end()) {
    if (found->second.topic->get_type_name() != type_name) {
      return fail("topic '" + name + "' already has the type '" + found->second.topic->get_type_name() + "'",
                  "give the topic of type '" + type_name + "' another name");
    }
    ++found->second.users;
    return found->second.topic;
  }
  Known& known = types_[type_name];
  if (known.topics == 0) {
    known.size = max_size_of(decoder);
    known.decoder = typeid(decoder);
    participant_->register_type(type, type_name);
  }
  fast::Topic* made = participant_->create_topic(name, type_name, fast::TOPIC_QOS_DEFAULT);
  if (made == nullptr) {
    if (known.topics == 0) {
      participant_->unregister_type(type_name);
      types_.erase(type_name);
    }
    return fail("DDS could not create topic '" + name + "' of type '" + type_name + "'",
                "see the message that DDS printed");
  }
  ++known.topics;
  topics_[name] = {made, 1};
  return made;
}

fast::DataWriter* OwnParticipant::make_writer(fast::Topic* topic, const fast::DataWriterQos& qos,
                                              fast::DataWriterListener* listener,
                                              const fast::StatusMask& mask) {
  const std::lock_guard lock{endpoints_};
  return publisher_->create_datawriter(topic, qos, listener, mask);
}

void OwnParticipant::end(fast::DataWriter*& writer) {
  if (writer == nullptr) return;
  writer->set_listener(nullptr);
  const std::lock_guard lock{endpoints_};
  std::size_t removed = 0;
  static_cast<void>(writer->clear_history(&removed));
  publisher_->delete_datawriter(writer);
  writer = nullptr;
}

fast::DataReader* OwnParticipant::make_reader(fast::Topic* topic, fast::DataReaderQos qos,
                                              fast::DataReaderListener* listener,
                                              const fast::StatusMask& mask, Receives receives) {
  if (receives == Receives::in_group && interfaces_->groups_reach_others()) {
    // With a group, a reader does not get the addresses of its participant unless they are given, too.
    qos.endpoint().unicast_locator_list.push_back(locator({}, channels_->port_for_samples()));
    qos.endpoint().multicast_locator_list.push_back(locator(kGroup, 0));  // RTPS assigns the port
  }
  const std::lock_guard lock{endpoints_};
  const ReceiveLock::Pause pause{filter_->receive_lock};
  return subscriber_->create_datareader(topic, qos, listener, mask);
}

void OwnParticipant::end(fast::DataReader*& reader) {
  if (reader == nullptr) return;
  reader->set_listener(nullptr);
  const std::lock_guard lock{endpoints_};
  const ReceiveLock::Pause pause{filter_->receive_lock};
  subscriber_->delete_datareader(reader);
  reader = nullptr;
}

void OwnParticipant::release(fast::Topic* topic) {
  const std::lock_guard lock{mutex_};
  const auto found = topics_.find(topic->get_name());
  TAKT_CHECK(found != topics_.end());
  if (--found->second.users > 0) return;
  const std::string type = topic->get_type_name();
  participant_->delete_topic(topic);
  topics_.erase(found);
  if (--types_[type].topics > 0) return;
  participant_->unregister_type(type);
  types_.erase(type);
}

OwnParticipant& own(Participant& participant) { return static_cast<OwnParticipant&>(participant); }

namespace {

template <class Bytes>
std::uint64_t hash(const Bytes& bytes) {
  std::uint64_t value = 14695981039346656037ULL;  // FNV-1a
  for (const auto byte : bytes) value = (value ^ static_cast<std::uint8_t>(byte)) * 1099511628211ULL;
  return value;
}

}  // namespace

std::uint64_t number_of(const rtps::GUID_t& guid) {
  rtps::InstanceHandle_t handle;
  handle = guid;
  return number_of(handle);
}

std::uint64_t number_of(const rtps::InstanceHandle_t& handle) {
  std::array<std::uint8_t, 16> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = handle.value[i];
  return hash(bytes);
}

std::uint64_t number_of(const rtps::GuidPrefix_t& prefix) { return hash(prefix.value); }

std::string policy_name(fast::QosPolicyId_t id) {
  switch (id) {
    case fast::DURABILITY_QOS_POLICY_ID:
      return "durability";
    case fast::DEADLINE_QOS_POLICY_ID:
      return "deadline";
    case fast::LIVELINESS_QOS_POLICY_ID:
      return "liveliness";
    case fast::RELIABILITY_QOS_POLICY_ID:
      return "reliability";
    case fast::OWNERSHIP_QOS_POLICY_ID:
      return "ownership";
    case fast::DESTINATIONORDER_QOS_POLICY_ID:
      return "destination order";
    case fast::LATENCYBUDGET_QOS_POLICY_ID:
      return "latency budget";
    case fast::PARTITION_QOS_POLICY_ID:
      return "partition";
    case fast::PRESENTATION_QOS_POLICY_ID:
      return "presentation";
    default:
      return "policy " + std::to_string(static_cast<unsigned>(id));
  }
}

}  // namespace takt::dds
