#include <takt/security/identity.hpp>

#include <algorithm>
#include <array>
#include <ctime>
#include <filesystem>

#include <takt/core/words.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/files.hpp>
#include <takt/os/writers.hpp>
#include <takt/security/choice.hpp>
#include "pki.hpp"

namespace takt::security {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostIdentityBytes = std::size_t{16} << 20;
constexpr const char* kCopyAgain = "copy the whole folder again from the machine of the authority";

/// Reads the files of one identity folder and collects the problems of these files.
class Folder {
 public:
  explicit Folder(std::string path) : path_(std::move(path)) {}

  std::string read(const char* file) {
    if (auto writers = os::check_writers(path_of(file)); !writers) add(file, writers.problems());
    auto content = os::read_file(path_of(file), kMostIdentityBytes);
    if (!content) {
      add(file, content.problems());
    } else if (!*content) {
      add(file, "there is no such file", kCopyAgain);
    } else {
      return **content;
    }
    return {};
  }
  template <class Object, class From>
  Object read(const char* file, From from, const char* kind) {
    const std::string text = read(file);
    Object object = text.empty() ? Object{} : from(text);
    if (!text.empty() && object == nullptr) add(file, std::string{"it is not a "} + kind, kCopyAgain);
    return object;
  }
  void add(const char* file, std::string what, std::string fix) {
    problems_.push_back({path_of(file), std::move(what), std::move(fix)});
  }
  void add(const char* file, const Problems& problems) {
    for (const Problem& problem : problems) add(file, problem.what, problem.fix);
  }
  [[nodiscard]] std::string path_of(const char* file) const { return (fs::path{path_} / file).string(); }
  [[nodiscard]] const Problems& problems() const { return problems_; }

 private:
  std::string path_;
  Problems problems_;
};

void check_access_of_others(Folder& folder) {
  const auto rights = os::rights_of(folder.path_of(kPrivateKey));
  if (!rights) return;  // the function that reads the key reports this problem
  if (rights->group_reads || rights->group_writes || rights->others_read || rights->others_write) {
    folder.add(kPrivateKey, "other users may read or write this private key",
               "run chmod 600 " + folder.path_of(kPrivateKey));
  }
}

}  // namespace

Result<Identity> read_identity(const std::string& path, std::int64_t now) {
  std::error_code error;
  Identity identity;
  identity.folder = fs::absolute(path, error).lexically_normal().string();
  if (!fs::is_directory(path, error)) {
    return Problem{path, "there is no such folder",
                   "name an identity folder that takt secure created, such as DIR/devices/NAME"};
  }
  Folder folder{identity.folder};
  check_access_of_others(folder);
  const auto authority = folder.read<Certificate>(kIdentityAuthority, certificate_from, "certificate");
  const auto access = folder.read<Certificate>(kAccessAuthority, certificate_from, "certificate");
  const auto certificate = folder.read<Certificate>(kCertificate, certificate_from, "certificate");
  const auto key = folder.read<Key>(kPrivateKey, key_from, "private key");
  const auto crl = folder.read<Crl>(kRevoked, crl_from, "list of revoked certificates");
  const std::string governance = folder.read(kGovernance);
  const std::string permissions = folder.read(kPermissions);

  std::string subject;
  if (certificate != nullptr) {
    identity.until = valid_until(*certificate);
    identity.serial = serial_of(*certificate);
    subject = subject_text(*certificate);
    const auto parsed = subject_from(subject);
    if (parsed)
      identity.subject = *parsed;
    else
      folder.add(kCertificate, "its subject " + in_quotes(subject) + " does not name a participant of a cell",
                 kCopyAgain);
  }
  if (authority != nullptr) identity.authority = announced_name(*authority);
  if (certificate != nullptr && authority != nullptr) {
    if (auto issued = check_issued(*certificate, *authority, now); !issued)
      folder.add(kCertificate, issued.problems());
  }
  if (certificate != nullptr && key != nullptr && !belong_together(*certificate, *key))
    folder.add(kPrivateKey, std::string{"this key does not belong to "} + kCertificate, kCopyAgain);
  if (crl != nullptr && authority != nullptr && !is_signed_by(*crl, *authority))
    folder.add(kRevoked, "its signature was not made by the authority", kCopyAgain);
  if (crl != nullptr && certificate != nullptr && is_revoked(*crl, *certificate))
    folder.add(kCertificate, "it was revoked", "to make it valid again, run takt secure renew");

  if (access != nullptr && !governance.empty()) {
    if (auto text = open_document(governance, *access); !text) folder.add(kGovernance, text.problems());
  }
  if (access != nullptr && !permissions.empty()) {
    const auto text = open_document(permissions, *access);
    if (!text) {
      folder.add(kPermissions, text.problems());
    } else {
      identity.domains = domains_in(*text);
      if (!subject.empty() && text->find("<subject_name>" + subject + "<") == std::string::npos)
        folder.add(kPermissions, "these permissions are for another participant, not for " + subject,
                   kCopyAgain);
    }
  }
  if (!folder.problems().empty()) return folder.problems();
  return identity;
}

std::string folder_of(const std::string& folder, Role role, const std::string& name) {
  if (name.empty()) return first_of(folder, role, os::wall_ns() / 1'000'000'000).folder;
  std::error_code error;
  const fs::path all = fs::path{folder} / folder_name(role);
  return fs::is_directory(all, error) ? (all / name).string() : folder;
}

Chosen first_of(const std::string& folder, Role role, std::int64_t now) {
  std::error_code error;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator{fs::path{folder} / folder_name(role), error})
    names.push_back(entry.path().string());
  std::sort(names.begin(), names.end());
  Chosen chosen;
  for (const std::string& name : names) {
    const auto identity = read_identity(name, now);
    if (identity) return {name, std::move(chosen.passed_over)};
    chosen.passed_over.insert(chosen.passed_over.end(), identity.problems().begin(),
                              identity.problems().end());
  }
  return {names.empty() ? folder : names[0]};
}

Certified certified(const x509_st& certificate) {
  return {.subject = subject_from(subject_text(certificate)).value_or(Subject{}),
          .until = valid_until(certificate),
          .serial = serial_of(certificate)};
}

std::string expired_text(std::int64_t until) {
  std::tm parts{};
  const auto seconds = static_cast<std::time_t>(until);
  ::gmtime_r(&seconds, &parts);
  std::array<char, 64> text{};
  std::strftime(text.data(), text.size(), "it expired on %Y-%m-%d at %H:%M:%S UTC", &parts);
  return text.data();
}

std::string expiry_warning(std::int64_t until, std::int64_t now) {
  if (until - now >= kSoon) return {};
  if (until <= now) return expired_text(until);
  const std::int64_t days = (until - now) / (24 * 3600);
  return days < 1 ? "it expires within a day"
                  : "it expires in " + std::to_string(days) + (days == 1 ? " day" : " days");
}

}  // namespace takt::security
