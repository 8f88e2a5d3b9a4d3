#include <takt/security/access.hpp>

#include <algorithm>
#include <charconv>
#include <ctime>
#include <set>

#include <takt/core/words.hpp>
#include <takt/model/validate.hpp>

namespace takt::security {

namespace {

/// The topics that every node writes, and the topics that every node reads.
constexpr std::array kNodeWrites{"takt/lifecycle", "takt/device", "takt/statistics", "takt/executor",
                                 "takt/port",      "takt/fault",  "takt/reply"};
constexpr std::array kNodeReads{"takt/lifecycle", "takt/device", "takt/command", kQuestionTopic};

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

/// Formats a time in seconds since 1970 as UTC: 2026-11-22T06:00:00.
std::string date(std::int64_t seconds) {
  const auto time = static_cast<std::time_t>(seconds);
  std::tm parts{};
  ::gmtime_r(&time, &parts);
  std::array<char, 32> text{};
  const std::size_t length = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &parts);
  return {text.data(), length};
}

/// The topics that a participant writes and reads on one domain, without duplicates.
struct Names {
  std::set<std::string> writes;
  std::set<std::string> reads;
};

void add_connections(const model::Cell& cell, int domain, int at, const Subject& subject, Names& names) {
  for (const model::Connection& connection : cell.connections) {
    if (connection.domain.value_or(domain) != at) continue;
    const std::string topic = model::topic_of(cell, connection);
    if (subject.role == Role::device) {
      const bool from_here = connection.from.given() && connection.from.device == subject.name;
      const bool to_here = connection.to.given() && connection.to.device == subject.name;
      if (from_here && to_here && connection.topic.empty()) continue;  // the samples do not leave the device
      if (from_here) names.writes.insert(topic);
      if (to_here) names.reads.insert(topic);
    } else {
      if (!connection.from.given()) names.writes.insert(topic);
      if (!connection.to.given()) names.reads.insert(topic);
    }
  }
}

std::string topics(const char* element, const std::vector<std::string>& names) {
  if (names.empty()) return "";
  std::string text = std::string{"        <"} + element + ">\n          <topics>\n";
  for (const std::string& name : names) text += "            <topic>" + escaped(name) + "</topic>\n";
  return text + "          </topics>\n        </" + element + ">\n";
}

std::string ids(const std::vector<int>& domains) {
  std::string text;
  for (const int domain : domains) text += "<id>" + std::to_string(domain) + "</id>";
  return text;
}

constexpr const char* kHead = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n";

}  // namespace

const char* to_text(Role role) {
  switch (role) {
    case Role::device:
      return "device";
    case Role::operator_:
      return "operator";
    case Role::observer:
      return "observer";
    case Role::program:
      return "program";
  }
  return "?";
}

std::string folder_name(Role role) { return std::string{to_text(role)} + "s"; }

std::string to_text(const Subject& subject) {
  return "CN=" + subject.name + ",OU=" + to_text(subject.role) + ",O=" + subject.cell;
}

std::optional<Subject> subject_from(std::string_view text) {
  for (const Role role : kRoles) {
    const std::string middle = std::string{",OU="} + to_text(role) + ",O=";
    const std::size_t at = text.find(middle);
    if (!text.starts_with("CN=") || at == std::string_view::npos) continue;
    Subject subject{std::string{text.substr(at + middle.size())}, role, std::string{text.substr(3, at - 3)}};
    if (model::is_valid_name(subject.cell) && model::is_valid_name(subject.name)) return subject;
  }
  return std::nullopt;
}

std::vector<int> domains_of(const model::Cell& cell, int domain) {
  std::set<int> all{domain};
  for (const model::Connection& connection : cell.connections) {
    if (connection.domain) all.insert(*connection.domain == cell.domain ? domain : *connection.domain);
  }
  return {all.begin(), all.end()};
}

std::vector<Access> access_of(const model::Cell& given, int domain, const Subject& subject) {
  model::Cell cell = given;
  for (model::Connection& connection : cell.connections) {
    if (connection.domain == cell.domain) connection.domain.reset();
  }
  const std::string own_topics = model::kOwnTopics + cell.name + "/";
  std::vector<Access> all;
  for (const int at : domains_of(cell, domain)) {
    Names names;
    if (subject.role != Role::observer) add_connections(cell, domain, at, subject, names);
    if (at == domain) {
      switch (subject.role) {
        case Role::device:
          names.writes.insert(kNodeWrites.begin(), kNodeWrites.end());
          names.reads.insert(kNodeReads.begin(), kNodeReads.end());
          names.writes.insert(own_topics + subject.name + "/*");
          names.reads.insert(own_topics + subject.name + "/*");
          break;
        case Role::operator_:
          names.writes.insert({"takt/command", kQuestionTopic, own_topics + "*"});
          names.reads.insert("*");
          break;
        case Role::observer:
          names.writes.insert(kQuestionTopic);
          names.reads.insert("*");
          break;
        case Role::program:
          break;
      }
    }
    if (names.writes.empty() && names.reads.empty()) continue;
    all.push_back({at, {names.writes.begin(), names.writes.end()}, {names.reads.begin(), names.reads.end()}});
  }
  return all;
}

Problems obstacles(const model::Cell& cell) {
  Problems problems;
  if (cell.discovery.kind == model::Discovery::Kind::server) {
    problems.push_back(model::problem_at(
        cell.texts(), cell.line,
        "a cell with security cannot use a discovery server: Fast DDS 2.9 does not support both",
        "use discovery=\"multicast\", or \"peers\" if the network has no multicast"));
  }
  for (const model::Connection& connection : cell.connections) {
    if (connection.topic.find_first_of("*?[\\") == std::string::npos) continue;
    problems.push_back(
        model::problem_at(cell.texts(), connection.line,
                          "the topic " + in_quotes(connection.topic) +
                              " would be a pattern in the permissions and also grant access to other topics",
                          "use a name without * ? [ and \\"));
  }
  return problems;
}

std::string governance_xml(const std::vector<int>& domains) {
  return std::string{kHead} +
         "<dds xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
         "xsi:noNamespaceSchemaLocation=\"http://www.omg.org/spec/DDS-Security/20170801/"
         "omg_shared_ca_domain_governance.xsd\">\n"
         "  <domain_access_rules>\n"
         "    <domain_rule>\n"
         "      <domains>" +
         ids(domains) +
         "</domains>\n"
         "      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>\n"
         "      <enable_join_access_control>true</enable_join_access_control>\n"
         "      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>\n"
         "      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>\n"
         "      <rtps_protection_kind>ENCRYPT</rtps_protection_kind>\n"
         "      <topic_access_rules>\n"
         "        <topic_rule>\n"
         "          <topic_expression>*</topic_expression>\n"
         "          <enable_discovery_protection>true</enable_discovery_protection>\n"
         "          <enable_liveliness_protection>true</enable_liveliness_protection>\n"
         "          <enable_read_access_control>true</enable_read_access_control>\n"
         "          <enable_write_access_control>true</enable_write_access_control>\n"
         "          <metadata_protection_kind>NONE</metadata_protection_kind>\n"
         "          <data_protection_kind>ENCRYPT</data_protection_kind>\n"
         "        </topic_rule>\n"
         "      </topic_access_rules>\n"
         "    </domain_rule>\n"
         "  </domain_access_rules>\n"
         "</dds>\n";
}

std::string permissions_xml(const Subject& subject, const std::vector<Access>& access, Validity validity) {
  std::string rules;
  for (const Access& each : access) {
    rules += "      <allow_rule>\n        <domains>" + ids({each.domain}) + "</domains>\n" +
             topics("publish", each.writes) + topics("subscribe", each.reads) + "      </allow_rule>\n";
  }
  return std::string{kHead} +
         "<dds xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
         "xsi:noNamespaceSchemaLocation=\"http://www.omg.org/spec/DDS-Security/20170801/"
         "omg_shared_ca_permissions.xsd\">\n"
         "  <permissions>\n"
         "    <grant name=\"" +
         subject.name + "\">\n      <subject_name>" + to_text(subject) +
         "</subject_name>\n      <validity><not_before>" + date(validity.from) + "</not_before><not_after>" +
         date(validity.until) + "</not_after></validity>\n" + rules +
         "      <default>DENY</default>\n    </grant>\n  </permissions>\n</dds>\n";
}

std::vector<int> domains_in(std::string_view xml) {
  constexpr std::string_view kOpen = "<id>";
  std::vector<int> domains;
  for (std::size_t at = xml.find(kOpen); at != std::string_view::npos; at = xml.find(kOpen, at + 1)) {
    int number = 0;
    const char* begin = xml.data() + at + kOpen.size();
    const auto [end, error] = std::from_chars(begin, xml.data() + xml.size(), number);
    if (error == std::errc{} && end != begin) domains.push_back(number);
  }
  return domains;
}

}  // namespace takt::security
