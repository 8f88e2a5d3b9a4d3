// Derives, from the connections of a cell, which topics each participant may write and read. These functions
// access no files and no network.
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

/// The role of a participant. A device runs modules. An operator may send commands. An observer may only
/// read. A program is not part of Takt and may use the topics of connections that have only one end in the
/// cell.
enum class Role { device, operator_, observer, program };
inline constexpr std::array kRoles{Role::device, Role::operator_, Role::observer, Role::program};
/// Returns the name of the role: "device", "operator", "observer" or "program".
const char* to_text(Role role);
/// Returns the name of the folder with the identities of this role: "devices", "operators", ...
std::string folder_name(Role role);

/// The participant that an identity names.
struct Subject {
  std::string cell;
  Role role = Role::device;
  std::string name;
  bool operator==(const Subject&) const = default;
};
/// Returns the subject in the form of RFC 2253, which permissions require: "CN=robot,OU=device,O=cell".
std::string to_text(const Subject& subject);
/// Parses a text in the form that to_text() returns. Returns std::nullopt if the text does not have this
/// form, or if a name in it is not valid.
std::optional<Subject> subject_from(std::string_view text);

/// The topics that a participant may write and read on one domain. A `*` in a topic matches any text.
struct Access {
  int domain = 0;
  std::vector<std::string> writes;
  std::vector<std::string> reads;
};

/// The topic on which observers send commands. Nodes handle this topic like takt/command, but accept on it
/// only commands that change no module.
inline constexpr const char* kQuestionTopic = "takt/question";

/// Returns the topics that the subject may use on the cell's own domain, `domain`, and on other domains of
/// its connections. A device may use the topics of every node, the topics of its own connections, and every
/// topic whose name begins with takt/CELL/DEVICE/.
std::vector<Access> access_of(const model::Cell& cell, int domain, const Subject& subject);

/// Returns the domains that the cell uses: its own domain, `domain`, and those of its connections.
std::vector<int> domains_of(const model::Cell& cell, int domain);

/// Returns the reasons why DDS Security cannot protect this cell: a topic name that would be a pattern in the
/// permissions, or a discovery server.
Problems obstacles(const model::Cell& cell);

/// A time span, in seconds since 1970.
struct Validity {
  std::int64_t from = 0;
  std::int64_t until = 0;
};

/// These functions return the two documents of DDS Security (sections 9.4.1.2 and 9.4.1.3). With these
/// documents, DDS encrypts all traffic on the domains, rejects participants without an identity, and requires
/// a permission for each topic.
std::string governance_xml(const std::vector<int>& domains);
std::string permissions_xml(const Subject& subject, const std::vector<Access>& access, Validity validity);

/// Returns the domains that a document from permissions_xml() or governance_xml() contains.
std::vector<int> domains_in(std::string_view xml);

}  // namespace takt::security
