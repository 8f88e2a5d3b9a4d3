// Who may write and read which topic, as the connections of a cell have it. Pure.
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

/// A device runs modules; an operator commands; an observer looks; a program that is not Takt's has the ends
/// of connections that no module has.
enum class Role { device, operator_, observer, program };
inline constexpr std::array kRoles{Role::device, Role::operator_, Role::observer, Role::program};
/// "device", "operator", "observer", "program"
const char* to_text(Role role);
/// The folder of its identities: "devices", "operators", ...
std::string folder_name(Role role);

/// Whom an identity names.
struct Subject {
  std::string cell;
  Role role = Role::device;
  std::string name;
  bool operator==(const Subject&) const = default;
};
/// As RFC 2253 has it, which is how permissions must name whom they are for: "CN=robot,OU=device,O=cell".
std::string to_text(const Subject& subject);
/// None where it is not of this form, or a name in it is none.
std::optional<Subject> subject_from(std::string_view text);

/// What may be done on one domain. Expressions: a name, or one with '*' for any text.
struct Access {
  int domain = 0;
  std::vector<std::string> writes;
  std::vector<std::string> reads;
};

/// On which a reader that may only look asks what changes nothing; as takt/command otherwise.
inline constexpr const char* kQuestionTopic = "takt/question";

/// On the domain of the cell (`domain`), and those of its connections that are on others. A device: what
/// nodes say and hear, the topics of its connections, and every topic below takt/CELL/DEVICE/.
std::vector<Access> access_of(const model::Cell& cell, int domain, const Subject& subject);

/// The domains that the cell uses, with `domain` as its own.
std::vector<int> domains_of(const model::Cell& cell, int domain);

/// What keeps a cell from being secured: a topic that would read as an expression, a discovery server.
Problems obstacles(const model::Cell& cell);

/// Between these, seconds since 1970.
struct Validity {
  std::int64_t from = 0;
  std::int64_t until = 0;
};

/// The documents of DDS Security (its sections 9.4.1.2 and 9.4.1.3): everything that is said on these domains
/// is encrypted, nobody without an identity is heard, every topic is granted or not at all.
std::string governance_xml(const std::vector<int>& domains);
std::string permissions_xml(const Subject& subject, const std::vector<Access>& access, Validity validity);

/// The domains that permissions_xml() or governance_xml() was made for.
std::vector<int> domains_in(std::string_view xml);

}  // namespace takt::security
