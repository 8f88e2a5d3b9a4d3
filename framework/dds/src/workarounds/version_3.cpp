// For Fast DDS 3: what the functions do that other files of this folder define for Fast DDS 2.9. README.md
// says which defects are left.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include <fastdds/rtps/attributes/RTPSParticipantAttributes.hpp>

#include "leases.hpp"
#include "message_size.hpp"
#include "own_announcement.hpp"
#include "participant_removal.hpp"
#include "removed_readers.hpp"
#include "replaced_function.hpp"
#include "second_announcement.hpp"
#include "spent_tokens.hpp"

#define BEGIN TAKT_RTPS "3PDP7initPDPEPNS1_19RTPSParticipantImplE"
#define EXCHANGE_KEYS                                                                                \
  TAKT_RTPS                                                                                          \
  "8security15SecurityManager27exchange_participant_cryptoESt10shared_ptrINS2_6HandleEERKNS1_6GUID_" \
  "tE"
#define NEXT_PAUSE TAKT_RTPS "3PDP30set_next_announcement_intervalEv"
#define SET_PAUSE TAKT_RTPS "10TimedEvent15update_intervalERKNS0_3dds6Time_tE"
#define ASSIGN TAKT_RTPS "9PDPSimple21assignRemoteEndpointsEPNS1_20ParticipantProxyDataE"
#define FOLLOWS TAKT_RTPS "9PDPSimple20updateInfoMatchesEDPEv"
#define UPDATE TAKT_RTPS "3PDP39local_participant_attributes_update_ntsERKNS1_25RTPSParticipantAttributesE"
#define FOUND TAKT_RTPS "9PDPSimple26notifyAboveRemoteEndpointsERKNS1_20ParticipantProxyDataEb"
#define HEAR                                                                                             \
  TAKT_RTPS                                                                                              \
  "28PDPSecurityInitiatorListener18process_alive_dataEPNS1_20ParticipantProxyDataERS3_RNS1_6GUID_tEPNS1" \
  "_10RTPSReaderERSt11unique_lockISt15recursive_mutexE"
#define MATCH TAKT_RTPS "9PDPSimple33assign_low_level_remote_endpointsERKNS1_20ParticipantProxyDataEb"

namespace takt::dds {

namespace {

// See own_announcement.cpp.
constexpr std::chrono::milliseconds kSilence{500};

void* discovery = nullptr;                                    // the participant discovery of Fast DDS (PDP)
std::atomic<std::recursive_mutex*> discovery_mutex{nullptr};  // null until somebody has announced itself
bool follows_others = false;
bool is_server = false;
std::vector<os::Ipv4> own_addresses;  // empty until the first change
thread_local std::optional<rtps::GuidPrefix_t> changed_client;

// The next announcements with short pauses. The mutex protects both.
std::mutex pause_mutex;
std::uint32_t short_pauses = kFirstAnnouncements;
Nanoseconds next_pause = kFirstPause;
thread_local bool sets_pause = false;  // of the announcements

// Participants that have ended leave their number behind. If there are so many, all are forgotten.
constexpr std::size_t kMostOld = 4096;

std::mutex old_mutex;
std::set<wire::ParticipantNumber> old_members;
// The other participant of the authentication that this thread has completed last.
thread_local wire::ParticipantNumber authenticated{};

using ExchangeKeys = bool(void* manager, void* keys, const rtps::GUID_t& other);
using Update = void(void* discovery, const rtps::RTPSParticipantAttributes& attributes);
using Follows = bool(void* discovery);
using Find = void*(void* discovery, const rtps::GuidPrefix_t& participant);
using Assign = void(void* discovery, void* participant);
using Add = void*(void* discovery, const rtps::GUID_t& participant, bool with_lease, const void* data);
using Hear = void(void* listener, void* known, void* announced, rtps::GUID_t& writer, void* reader,
                  std::unique_lock<std::recursive_mutex>& lock);
using Found = void(void* discovery, const void* participant, bool is_authenticated);
using Announcing = void(void* discovery);
using SetPause = bool(void* timer, const Duration& pause);

using Begin = bool(void* discovery, void* participant);
using Announce = void(void* discovery, bool has_changed, bool leaves);

/// The functions of Fast DDS that this file calls or replaces.
struct Originals {
  Begin* begin = replaced<Begin>(BEGIN);
  Announce* announce = replaced<Announce>(TAKT_RTPS "3PDP24announceParticipantStateEbb");
  ExchangeKeys* exchange_keys = replaced<ExchangeKeys>(EXCHANGE_KEYS);
  Found* found = replaced<Found>(FOUND);
  Found* match = replaced<Found>(MATCH);  // the readers and writers of discovery with those of a participant
  Follows* follows = replaced<Follows>(FOLLOWS);
  Update* update = replaced<Update>(UPDATE);
  Find* find = replaced<Find>(TAKT_RTPS "3PDP26get_participant_proxy_dataERKNS1_12GuidPrefix_tE");
  Add* add = replaced<Add>(TAKT_RTPS
                           "3PDP26add_participant_proxy_dataERKNS1_6GUID_tEbPKNS1_20ParticipantProxyDataE");
  Hear* hear = replaced<Hear>(HEAR);
  Assign* assign =
      replaced<Assign>(TAKT_RTPS "9PDPServer21assignRemoteEndpointsEPNS1_20ParticipantProxyDataE");
  Assign* assign_simply = replaced<Assign>(ASSIGN);
  Announcing* next_pause = replaced<Announcing>(NEXT_PAUSE);
  SetPause* set_pause = replaced<SetPause>(SET_PAUSE);
  Announcing* stop_announcing = replaced<Announcing>(TAKT_RTPS "3PDP27stopParticipantAnnouncementEv");
  Announcing* restart_announcing = replaced<Announcing>(TAKT_RTPS "3PDP28resetParticipantAnnouncementEv");
};
const Originals& originals() noexcept {
  static const Originals found;
  return found;
}

void announce(bool leaves) { originals().announce(discovery, true, leaves); }

rtps::GUID_t guid_of(const wire::ParticipantNumber& participant) {
  rtps::GUID_t guid{{}, rtps::c_EntityId_RTPSParticipant};
  std::copy(participant.begin(), participant.end(), guid.guidPrefix.value);
  return guid;
}

/// The first members of Fast DDS's class ParticipantProxyData.
struct ParticipantData {
  const void* functions;
  rtps::ProtocolVersion_t version;
  rtps::GUID_t guid;
  rtps::VendorId_t vendor;
  rtps::ProductVersion_t product;
  std::uint32_t domain;
  bool expects_inline_qos;
  std::uint32_t endpoints;
};
// In `endpoints`: the writers and readers of authentication messages and of keys, in both directions.
constexpr std::uint32_t kAuthentication = 15U << 22U;

bool is_old(const wire::ParticipantNumber& participant) {
  const std::lock_guard lock{old_mutex};
  return old_members.contains(participant);
}

}  // namespace

// ---- Mended in version 3

void remove_readers_without_deadlock() noexcept {}
void drop_spent_tokens() noexcept {}

// ---- own_announcement.hpp

void prepare_own_announcement(bool follows, bool serves) noexcept {
  follows_others = follows;
  is_server = serves;
  static_cast<void>(originals());
}
// Version 3 asks the transport for the addresses, and announces them also for readers and writers.
void announce_addresses(fast::DomainParticipant& participant, const std::vector<os::Ipv4>& addresses) {
  own_addresses = addresses;
  participant.set_qos(participant.get_qos());
}
void announce_again() {}
void has_announced(const rtps::GuidPrefix_t& participant) noexcept { changed_client = participant; }
void follow_client() {
  if (!is_server || !changed_client) return;
  void* const client = originals().find(discovery, *std::exchange(changed_client, {}));
  if (client != nullptr) originals().assign(discovery, client);
}

// Sets the pause until the next announcement.
Announcing set_next_pause asm(NEXT_PAUSE);
void set_next_pause(void* own) {
  sets_pause = true;
  originals().next_pause(own);
  sets_pause = false;
}
SetPause set_pause asm(SET_PAUSE);
bool set_pause(void* timer, const Duration& given) {
  if (!sets_pause) return originals().set_pause(timer, given);
  Duration pause = given;
  {
    const std::lock_guard lock{pause_mutex};
    if (short_pauses > 0) {
      --short_pauses;
      pause = duration(std::exchange(next_pause, 2 * next_pause));
    }
  }
  return originals().set_pause(timer, pause);
}

// Called when this participant has found another one. Fast DDS then announces this participant once, perhaps
// before the other one can receive it. With DDS Security there are no more, because one that is sent just
// when this machine loses an address does harm: a participant that hears it first sends all its
// authentication messages to this address (tests/system/interfaces).
Assign assign_simply asm(ASSIGN);
void assign_simply(void* own, void* other) {
  originals().assign_simply(own, other);
  if (!follows_others) return;  // with DDS Security
  {
    const std::lock_guard lock{pause_mutex};
    if (short_pauses > 0) return;
    short_pauses = kMoreAnnouncements;
    next_pause = kMorePause;
  }
  originals().stop_announcing(own);
  set_next_pause(own);
  originals().restart_announcing(own);
}

// Called by set_qos(). A discovery server would announce for ever the addresses that it was given.
Update update_own asm(UPDATE);
void update_own(void* own, const rtps::RTPSParticipantAttributes& given) {
  rtps::RTPSParticipantAttributes attributes = given;
  rtps::LocatorList_t& announced = attributes.builtin.metatrafficUnicastLocatorList;
  if (!own_addresses.empty() && !announced.empty()) {
    rtps::Locator_t each = *announced.begin();
    announced.clear();
    for (const os::Ipv4& address : own_addresses) {
      rtps::IPLocator::setIPv4(each, address[0], address[1], address[2], address[3]);
      announced.push_back(each);
    }
  }
  originals().update(own, attributes);
}

// Fast DDS asks this when a known participant announces something new.
Follows follows asm(FOLLOWS);
bool follows(void*) { return follows_others; }

Begin begin_discovery asm(BEGIN);
bool begin_discovery(void* made, void* participant) {
  discovery = made;
  return originals().begin(made, participant);
}

void forget(const wire::ParticipantNumber& participant) {
  forget_participant(discovery, guid_of(participant));
}

// Called for each announcement without encryption, with the lock of discovery.
Hear hear asm(HEAR);
void hear(void* listener, void* known, void* announced, rtps::GUID_t& writer, void* reader,
          std::unique_lock<std::recursive_mutex>& lock) {
  discovery_mutex = lock.mutex();
  originals().hear(listener, known, announced, writer, reader, lock);
}

// Until a participant has authenticated and announced itself again, only the authentication of Fast DDS knows
// it, and discovery, which forgets participants after their lease, does not. So it gets to know it first.
void forget_silent(const wire::ParticipantNumber& participant) {
  std::recursive_mutex* const mutex = discovery_mutex;
  if (mutex == nullptr) return;
  const rtps::GUID_t guid = guid_of(participant);
  {
    const std::lock_guard lock{*mutex};
    if (originals().find(discovery, guid.guidPrefix) != nullptr) return;  // it has a lease
    void* const added = originals().add(discovery, guid, false, nullptr);
    if (added == nullptr) return;
    static_cast<ParticipantData*>(added)->endpoints = kAuthentication;
  }
  forget_participant(discovery, guid);
}

void rejoin(PacketFilter& filter, const std::map<wire::ParticipantNumber, std::string>& known,
            bool also_here) {
  filter.silence = also_here ? Silence::none : Silence::on_this_machine;
  announce(true);
  filter.silence = Silence::everywhere;
  announce(false);
  filter.silence = also_here ? Silence::everywhere : Silence::on_other_machines;
  std::this_thread::sleep_for(kSilence);
  for (const auto& [number, name] : known) {
    if (also_here || !is_near(number)) forget(number);
  }
  filter.silence = Silence::none;
  announce(false);
}

// ---- second_announcement.hpp

void prepare_for_old_members() noexcept { static_cast<void>(originals()); }

void note_member(const wire::ParticipantNumber& participant, bool is_old) {
  const std::lock_guard lock{old_mutex};
  if (!is_old) {
    old_members.erase(participant);
    return;
  }
  if (old_members.size() >= kMostOld) old_members.clear();
  old_members.insert(participant);
}

ExchangeKeys exchange_keys asm(EXCHANGE_KEYS);
bool exchange_keys(void* manager, void* keys, const rtps::GUID_t& other) {
  authenticated = number_in(other.guidPrefix);
  return originals().exchange_keys(manager, keys, other);
}

// Called directly after exchange_keys(), with the data of the announcement. Matches the readers and writers
// for the second announcement. An old member sends none, so this function does the rest at once: first as for
// a participant without DDS Security, then the readers and writers of encrypted discovery. Anybody may have
// sent the announcement without a version, so a member that is not old must be found, too.
Found found_participant asm(FOUND);
void found_participant(void* finder, const void* participant, bool is_authenticated) {
  originals().found(finder, participant, is_authenticated);
  if (!is_authenticated || !is_old(authenticated)) return;
  originals().found(finder, participant, false);
  originals().match(finder, participant, true);
}

// ---- leases.hpp: each sample of a writer with a lease stops and starts a timer

void renew_leases_quietly() noexcept {}

}  // namespace takt::dds
