// takt secure: creates and maintains the authority of a cell, and the identities that the authority issues.
// takt sign: signs components.
#include <algorithm>
#include <array>
#include <ctime>
#include <filesystem>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <takt/client/network.hpp>
#include <takt/core/words.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/model/validate.hpp>
#include <takt/os/clock.hpp>
#include <takt/security/authority.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

using security::Authority;
using security::Plan;
using security::Role;
using security::Subject;

struct SecureOptions {
  std::string file;
  std::string folder;
  std::string role;
  std::string name;
  std::vector<std::string> names;
  std::vector<std::string> operators;
  std::vector<std::string> observers;
  int days = 365;
  client::Network network;
};

std::int64_t now_s() { return os::wall_ns() / 1'000'000'000; }

std::string date(std::int64_t seconds) {
  const auto time = static_cast<std::time_t>(seconds);
  std::tm parts{};
  ::gmtime_r(&time, &parts);
  std::array<char, 16> text{};
  const std::size_t length = std::strftime(text.data(), text.size(), "%Y-%m-%d", &parts);
  return {text.data(), length};
}

/// Loads the cell from a descriptor. Fails if DDS Security cannot grant access to one of the cell's topics.
Result<Plan> plan_of(const std::string& file, const client::Network& network, std::string& text) {
  auto cell = descriptor::load(file, &text);
  if (!cell) return cell.problems();
  if (Problems problems = security::obstacles(*cell); !problems.empty()) return problems;
  const auto domain = client::domain_of(network, &*cell);
  if (!domain) return domain.problems();
  return Plan{std::move(*cell), *domain};
}

/// Loads the cell from the descriptor that the authority's folder contains.
Result<Plan> kept_plan(const Authority& authority) {
  const auto text = authority.descriptor();
  if (!text) return text.problems();
  const auto domain = authority.domain();
  if (!domain) return domain.problems();
  auto cell = descriptor::parse(*text, "cell.xml");
  if (!cell) return cell.problems();
  return Plan{std::move(*cell), *domain};
}

Result<void> admit_devices(Authority& authority, const Plan& plan, int days) {
  for (const model::Device& device : plan.cell.devices) {
    const Subject subject{authority.cell(), Role::device, device.name};
    const std::vector<Subject> there = authority.named(device.name);
    if (std::find(there.begin(), there.end(), subject) != there.end()) continue;
    if (auto issued = authority.issue(subject, plan, days, now_s()); !issued) return issued;
  }
  return {};
}

int show_authority(const std::string& folder) {
  const auto authority = Authority::open(folder);
  if (!authority) return refuse(authority.problems());
  const auto domain = authority->domain();
  std::string text = fmt::format("cell {}, domain {}\n", authority->cell(), domain ? *domain : -1);
  Problems problems;
  const std::int64_t now = now_s();
  for (const security::Member& member : authority->members(now)) {
    const std::string warning = security::expiry_warning(member.until, now);
    const std::string state = member.revoked            ? "revoked"
                              : member.until <= now     ? "expired " + date(member.until)
                              : member.problems.empty() ? "until " + date(member.until)
                                                        : "not valid";
    text += fmt::format("  {:<9} {:<24} {}{}\n", to_text(member.subject.role), member.subject.name, state,
                        warning.empty() || member.revoked || member.until <= now ? "" : ": " + warning);
    problems.insert(problems.end(), member.problems.begin(), member.problems.end());
  }
  if (!print(text)) return 1;
  return problems.empty() ? 0 : refuse(problems);
}

int init(const SecureOptions& options) {
  std::string text;
  const auto plan = plan_of(options.file, options.network, text);
  if (!plan) return refuse(plan.problems());
  for (const auto* names : {&options.operators, &options.observers}) {
    for (const std::string& name : *names) {
      if (!model::is_valid_name(name))
        return refuse({fail(
            in_quotes(name) + " is not a valid name",
            "start with a letter or '_', then use letters, digits, '_' and '-', at most 63 characters")});
    }
  }
  auto authority = Authority::create(options.folder, plan->cell.name, now_s());
  if (!authority) return refuse(authority.problems());
  if (auto kept = authority->keep(text, plan->domain); !kept) return refuse(kept.problems());
  if (auto admitted = admit_devices(*authority, *plan, options.days); !admitted)
    return refuse(admitted.problems());
  const std::vector<std::string> operators =
      options.operators.empty() ? std::vector<std::string>{"operator"} : options.operators;
  for (const auto& [role, names] :
       {std::pair{Role::operator_, operators}, {Role::observer, options.observers}}) {
    for (const std::string& name : names) {
      const auto issued = authority->issue({authority->cell(), role, name}, *plan, options.days, now_s());
      if (!issued) return refuse(issued.problems());
    }
  }
  return show_authority(options.folder);
}

int add(const SecureOptions& options) {
  auto authority = Authority::open(options.folder);
  if (!authority) return refuse(authority.problems());
  const auto plan = kept_plan(*authority);
  if (!plan) return refuse(plan.problems());
  if (!model::is_valid_name(options.name)) {
    return refuse(
        {fail(in_quotes(options.name) + " is not a valid name",
              "start with a letter or '_', then use letters, digits, '_' and '-', at most 63 characters")});
  }
  const auto role = std::find_if(security::kRoles.begin(), security::kRoles.end(),
                                 [&](Role each) { return to_text(each) == options.role; });
  const Subject subject{authority->cell(), *role, options.name};
  if (security::access_of(plan->cell, plan->domain, subject).empty()) {
    return refuse(
        {fail("cell " + authority->cell() + " has no topics for programs outside Takt: each connection " +
                  "has two ends in the cell",
              "remove from= or to= from a connection, then run takt secure update")});
  }
  if (auto issued = authority->issue(subject, *plan, options.days, now_s()); !issued)
    return refuse(issued.problems());
  return show_authority(options.folder);
}

int update_authority(const SecureOptions& options) {
  auto authority = Authority::open(options.folder);
  if (!authority) return refuse(authority.problems());
  std::string text;
  client::Network network = options.network;
  if (const auto domain = authority->domain(); domain && !network.domain) network.domain = *domain;
  const auto plan = plan_of(options.file, network, text);
  if (!plan) return refuse(plan.problems());
  if (plan->cell.name != authority->cell()) {
    return refuse(
        {{options.file,
          "describes cell " + plan->cell.name + ", but the authority belongs to cell " + authority->cell(),
          "create another authority for this cell with takt secure init"}});
  }
  if (auto kept = authority->keep(text, plan->domain); !kept) return refuse(kept.problems());
  if (auto admitted = admit_devices(*authority, *plan, options.days); !admitted)
    return refuse(admitted.problems());
  if (auto written = authority->document(*plan, now_s()); !written) return refuse(written.problems());
  for (const security::Member& member : authority->members(now_s())) {
    const auto& devices = plan->cell.devices;
    const bool in_cell = std::any_of(devices.begin(), devices.end(), [&](const model::Device& device) {
      return device.name == member.subject.name;
    });
    if (member.subject.role != Role::device || member.revoked || in_cell) continue;
    tell(
        fmt::format("device {0} is no longer in the cell, but its identity is still valid; use takt secure "
                    "revoke {1} {0} to revoke it",
                    member.subject.name, options.folder));
  }
  return show_authority(options.folder);
}

/// Finds the identities with these names. Fails if one of the names does not exist.
Result<std::vector<Subject>> subjects_named(const Authority& authority,
                                            const std::vector<std::string>& names) {
  std::vector<Subject> subjects;
  Problems problems;
  for (const std::string& name : names) {
    const auto found = authority.named(name);
    if (found.empty())
      problems.push_back(
          fail("there is no identity " + in_quotes(name), "list the identities with takt secure show"));
    subjects.insert(subjects.end(), found.begin(), found.end());
  }
  if (!problems.empty()) return problems;
  return subjects;
}

int revoke(const SecureOptions& options) {
  auto authority = Authority::open(options.folder);
  if (!authority) return refuse(authority.problems());
  const auto subjects = subjects_named(*authority, options.names);
  if (!subjects) return refuse(subjects.problems());
  for (const Subject& subject : *subjects) {
    if (auto revoked = authority->revoke(subject, now_s()); !revoked) return refuse(revoked.problems());
  }
  if (!print("copy crl.pem into the identity folders on every machine of the cell; nodes and operators then "
             "reject revoked identities at once\n"))
    return 1;
  return show_authority(options.folder);
}

int renew(const SecureOptions& options) {
  auto authority = Authority::open(options.folder);
  if (!authority) return refuse(authority.problems());
  const auto plan = kept_plan(*authority);
  if (!plan) return refuse(plan.problems());
  auto subjects = subjects_named(*authority, options.names);
  if (!subjects) return refuse(subjects.problems());
  if (options.names.empty()) {
    for (const security::Member& member : authority->members(now_s())) {
      if (!member.revoked) subjects->push_back(member.subject);
    }
  }
  for (const Subject& subject : *subjects) {
    if (auto issued = authority->issue(subject, *plan, options.days, now_s(), true); !issued)
      return refuse(issued.problems());
  }
  return show_authority(options.folder);
}

}  // namespace

void add_secure(CLI::App& app, Chosen& chosen) {
  auto* secure = app.add_subcommand(
      "secure", "Issue and renew the identities of a cell on an untrusted network (DDS Security)");
  secure->require_subcommand(1);
  secure->footer(
      "Copy each folder DIR/devices/NAME, DIR/operators/NAME or DIR/observers/NAME to the machine that\n"
      "needs this identity, and name the folder there with --security or TAKT_SECURITY.\n"
      "Never copy DIR/authority: anyone who has it can issue any identity.");
  const auto command = [&](const char* name, const char* text, int (*run)(const SecureOptions&)) {
    auto options = std::make_shared<SecureOptions>();
    auto* made = secure->add_subcommand(name, text);
    made->callback([options, run, &chosen] { chosen = [options, run] { return run(*options); }; });
    return std::pair{made, options};
  };
  const auto days = [](CLI::App* made, SecureOptions& options) {
    made->add_option("--days", options.days,
                     "the number of days for which the identities are valid, 1 to 3650")
        ->type_name("N")
        ->check(CLI::Range(1, 3650).description(""))
        ->capture_default_str();
  };
  const auto domain = [](CLI::App* made, SecureOptions& options) {
    made->add_option("--domain", options.network.domain,
                     "the DDS domain of the cell (default: TAKT_DOMAIN, else the descriptor's, else 0)")
        ->type_name("N")
        ->check(CLI::Range(0, 232).description(""));
  };
  const auto folder = [](CLI::App* made, SecureOptions& options) {
    made->add_option("DIR", options.folder, "the authority's folder")->required();
  };
  {
    const auto [made, options] = command(
        "init", "Create an authority, with an identity for each device of the cell and for operators", init);
    made->add_option("FILE", options->file, "the cell")->required();
    folder(made, *options);
    made->add_option(
            "--operator", options->operators,
            "an operator, who may send commands (default: one operator named 'operator'); may be repeated")
        ->type_name("NAME");
    made->add_option("--observer", options->observers, "an observer, who may only read; may be repeated")
        ->type_name("NAME");
    days(made, *options);
    domain(made, *options);
  }
  {
    const auto [made, options] =
        command("add", "Issue an identity to another operator, observer, or program outside Takt", add);
    folder(made, *options);
    made->add_option("ROLE", options->role,
                     "operator, observer, or program; a program may use the topics of connections with only "
                     "one end in the cell")
        ->required()
        ->check(CLI::IsMember({"operator", "observer", "program"}).description(""));
    made->add_option("NAME", options->name, "the name of the new identity")->required();
    days(made, *options);
  }
  {
    const auto [made, options] = command(
        "update",
        "After a change of the cell, issue new permissions to all identities, and identities to new devices",
        update_authority);
    folder(made, *options);
    made->add_option("FILE", options->file, "the cell")->required();
    days(made, *options);
    made->add_option("--domain", options->network.domain, "the new DDS domain, if it has changed")
        ->type_name("N")
        ->check(CLI::Range(0, 232).description(""));
  }
  {
    const auto [made, options] = command("renew", "Replace keys and certificates before they expire", renew);
    folder(made, *options);
    made->add_option("NAME", options->names, "the identities to renew (default: all)");
    days(made, *options);
  }
  {
    const auto [made, options] = command("revoke", "Revoke identities", revoke);
    folder(made, *options);
    made->add_option("NAME", options->names, "the identities to revoke")->required();
  }
  {
    const auto [made, options] = command("show", "List the identities, and how long each of them is valid",
                                         [](const SecureOptions& o) { return show_authority(o.folder); });
    folder(made, *options);
  }
}

void add_sign(CLI::App& app, Chosen& chosen) {
  auto files = std::make_shared<std::vector<std::string>>();
  auto folder = std::make_shared<std::string>();
  auto* made = app.add_subcommand("sign", "Sign components: write FILE.sig beside each FILE");
  made->add_option("FILE", *files, "components (.so or .exe)")->required();
  made->add_option("--key", *folder, "the folder of the signing authority, created by takt secure init")
      ->type_name("DIR")
      ->required();
  made->footer(
      "The command prints the name of a certificate. To make a node accept only signed components, name\n"
      "that certificate with --signed-by or TAKT_SIGNED_BY, or copy it as components.cert.pem to the folder\n"
      "of the node's identity.");
  made->callback([files, folder, &chosen] {
    chosen = [files, folder] {
      auto authority = Authority::open(*folder);
      if (!authority) return refuse(authority.problems());
      const auto certificate = authority->sign_components(*files, now_s());
      if (!certificate) return refuse(certificate.problems());
      return print(fmt::format("{} signed; certificate: {}\n", files->size(), on_one_line(*certificate))) ? 0
                                                                                                          : 1;
    };
  });
}

}  // namespace takt::tool
