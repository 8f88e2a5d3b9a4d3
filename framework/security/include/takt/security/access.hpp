// The topics that each participant of a cell may write and read, derived from the cell's connections. Pure
// functions.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::security {

/// A device runs modules. An operator may send commands. An observer is read-only. A program is outside Takt
/// and may use the topics of connections that have only one end in the cell.
enum class Role { device, operator_, observer, program };
inline constexpr std::array kRoles{Role::device, Role::operator_, Role::observer, Role::program};
/// "device", "operator", "observer", "program"
const char* to_text(Role role);
/// The folder of the identities of a role: "devices", "operators", ...
std::string folder_name(Role role);

/// The participant that an identity names.
struct Subject {
  std::string cell;
  Role role = Role::device;
  std::string name;
  bool operator==(const Subject&) const = default;
};
/// The subject in the form of RFC 2253, which permissions require: "CN=robot,OU=device,O=cell".
std::string to_text(const Subject& subject);
/// None if the text does not have this form, or if a name in it is not valid.
std::optional<Subject> subject_from(std::string_view text);

/// The topics that a participant may write and read on one domain. A '*' in a topic stands for any text.
struct Access {
  int domain = 0;
  std::vector<std::string> writes;
  std::vector<std::string> reads;
};

/// The topic on which observers send requests. It works like takt/command, but its requests change nothing.
inline constexpr const char* kQuestionTopic = "takt/question";

/// The access of the subject on the cell's own domain (`domain`) and on the other domains of its connections.
/// A device gets the topics of a node, the topics of its connections, and every topic below
/// takt/CELL/DEVICE/.
std::vector<Access> access_of(const model::Cell& cell, int domain, const Subject& subject);

/// The domains that the cell uses, with `domain` as its own.
std::vector<int> domains_of(const model::Cell& cell, int domain);

/// The reasons why a cell cannot be secured: a topic that permissions would read as a pattern, or a discovery
/// server.
Problems obstacles(const model::Cell& cell);

/// A time span, in seconds since 1970.
struct Validity {
  std::int64_t from = 0;
  std::int64_t until = 0;
};

/// The documents of DDS Security (sections 9.4.1.2 and 9.4.1.3). All traffic on these domains is encrypted,
/// participants without an identity are rejected, and each topic needs a permission.
std::string governance_xml(const std::vector<int>& domains);
std::string permissions_xml(const Subject& subject, const std::vector<Access>& access, Validity validity);

/// The domains in a document of permissions_xml() or governance_xml().
std::vector<int> domains_in(std::string_view xml);

}  // namespace takt::security
