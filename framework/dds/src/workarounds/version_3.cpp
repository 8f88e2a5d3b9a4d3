// For Fast DDS 3: what the functions do that other files of this folder define for Fast DDS 2.9, by replacing
// private functions. README.md says which defects are left.
#include "announced_once.hpp"
#include "leases.hpp"
#include "message_size.hpp"
#include "own_announcement.hpp"
#include "reader_checks.hpp"
#include "removed_readers.hpp"
#include "resends.hpp"
#include "returning_readers.hpp"
#include "server_address.hpp"
#include "soon_repeated.hpp"
#include "spent_tokens.hpp"

namespace takt::dds {

// Mended in version 3
void remove_readers_without_deadlock() noexcept {}
void drop_spent_tokens() noexcept {}

// Version 3 asks the transport for the addresses, and announces them also for readers and writers.
void announce_addresses(fast::DomainParticipant& participant, const std::vector<os::Ipv4>&) {
  participant.set_qos(participant.get_qos());
}

// Not mended
void announce_once() noexcept {}
void renew_leases_quietly() noexcept {}
void keep_messages_short(bool) noexcept {}
void set_near(const wire::ParticipantNumber&, bool) {}
void prepare_own_announcement(bool) noexcept {}
void announce_again() {}
void follow_clients() {}
void rejoin(PacketFilter&, bool) {}
void check_what_readers_receive() noexcept {}
std::uint64_t refused_by_readers() noexcept { return 0; }
void limit_resends(std::function<void(const std::string&)>) {}
std::string obstacle_to(const wire::ParticipantNumber&) { return {}; }
void send_again_to_returning_readers() noexcept {}
void reach_server_at(std::optional<NamedServer>) {}
void repeat_lost_messages_soon() noexcept {}

}  // namespace takt::dds
