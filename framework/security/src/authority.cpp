#include <takt/security/authority.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <random>
#include <utility>

#include <takt/core/words.hpp>
#include <takt/os/files.hpp>
#include <takt/os/writers.hpp>
#include <takt/security/signature.hpp>
#include "pki.hpp"

namespace takt::security {

namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "authority";
constexpr const char* kIdentityKey = "ca.key.pem";
constexpr const char* kAccessKey = "permissions.key.pem";
constexpr const char* kComponentsKey = "components.key.pem";
constexpr const char* kDescriptor = "cell.xml";
constexpr const char* kDomain = "domain";
constexpr std::size_t kMostAuthorityBytes = std::size_t{32} << 20;

constexpr std::int64_t kDay = 24 * 3600;
/// The validity of a certificate begins this long before the certificate is issued, because the clocks of
/// machines differ.
constexpr std::int64_t kBefore = 3600;  // s
constexpr std::int64_t kAuthorityDays = 3650;

Result<std::string> read_authority_file(const fs::path& path) {
  if (auto writers = os::check_writers(path.string()); !writers) return writers.problems();
  auto content = os::read_file(path.string(), kMostAuthorityBytes);
  if (!content) return content.problems();
  if (!*content)
    return Problem{path.string(), "there is no such file", "create an authority with takt secure init"};
  return **std::move(content);
}

template <class Object, class From>
Result<void> read_into(Object& object, const fs::path& path, From from) {
  auto text = read_authority_file(path);
  if (!text) return text.problems();
  object = from(*text);
  if (object == nullptr) return Problem{path.string(), "it cannot be read", "restore it from a backup"};
  return {};
}

/// Returns random digits for the name of a new authority. The digits distinguish the identities of two cells
/// with the same name.
std::string new_mark() {
  std::random_device random;
  std::array<char, 9> digits{};
  std::snprintf(digits.data(), digits.size(), "%08x", random());
  return digits.data();
}

/// Writes several files into one folder, and stops at the first problem.
class Files {
 public:
  explicit Files(fs::path folder) : folder_(std::move(folder)) {
    keep(os::make_private_folder(folder_.string()));
  }
  Files& write(const char* name, const std::string& content) {
    if (result_) keep(os::replace_file((folder_ / name).string(), content));
    return *this;
  }
  [[nodiscard]] const Result<void>& result() const { return result_; }

 private:
  void keep(Result<void> result) { result_ = std::move(result); }
  fs::path folder_;
  Result<void> result_;
};

}  // namespace

struct Authority::Inside {
  fs::path folder;
  std::string cell;
  Key identity_key;
  Certificate identity;
  Key access_key;
  Certificate access;
  Crl crl;

  [[nodiscard]] fs::path own(const char* file) const { return folder / kFolder / file; }
  [[nodiscard]] fs::path of(const Subject& subject) const {
    return folder / folder_name(subject.role) / subject.name;
  }

  void write_documents(Files& files, const Subject& subject, const Plan& plan, std::int64_t now,
                       std::int64_t until) const {
    // The documents are valid from one day before to one day after the validity of the certificate, so that
    // time zones do not matter. The certificate still limits the validity.
    const Validity validity{now - kDay, until + kDay};
    const std::vector<Access> access_rules = access_of(plan.cell, plan.domain, subject);
    files
        .write(kGovernance,
               sign_document(governance_xml(domains_of(plan.cell, plan.domain)), *access, *access_key))
        .write(kPermissions,
               sign_document(permissions_xml(subject, access_rules, validity), *access, *access_key))
        .write(kIdentityAuthority, to_pem(*identity))
        .write(kAccessAuthority, to_pem(*access))
        .write(kRevoked, to_pem(*crl));
  }
};

Authority::Authority(std::unique_ptr<Inside> inside) noexcept : inside_(std::move(inside)) {}
Authority::Authority(Authority&&) noexcept = default;
Authority& Authority::operator=(Authority&&) noexcept = default;
Authority::~Authority() = default;

const std::string& Authority::cell() const noexcept { return inside_->cell; }

Result<Authority> Authority::create(const std::string& folder, const std::string& cell, std::int64_t now) {
  auto inside = std::make_unique<Inside>();
  inside->folder = folder;
  inside->cell = cell;
  std::error_code error;
  const fs::path own = inside->folder / kFolder;
  if (fs::exists(own, error)) {
    return Problem{own.string(), "an authority already exists and is not overwritten",
                   "use takt secure update, add or renew to change it"};
  }
  const Validity validity{now - kBefore, now + kAuthorityDays * kDay};
  inside->identity_key = make_key();
  inside->identity = make_certificate(Kind::authority, {cell, {}, "identities " + new_mark()},
                                      *inside->identity_key, nullptr, *inside->identity_key, validity);
  inside->access_key = make_key();
  inside->access = make_certificate(Kind::authority, {cell, {}, "permissions"}, *inside->access_key, nullptr,
                                    *inside->access_key, validity);
  inside->crl = make_crl(nullptr, nullptr, *inside->identity, *inside->identity_key, now - kBefore);
  if (auto made = os::make_private_folder(folder); !made) return made.problems();
  Files files{own};
  files.write(kIdentityKey, to_pem(*inside->identity_key))
      .write(kIdentityAuthority, to_pem(*inside->identity))
      .write(kAccessKey, to_pem(*inside->access_key))
      .write(kAccessAuthority, to_pem(*inside->access))
      .write(kRevoked, to_pem(*inside->crl));
  if (!files.result()) return files.result().problems();
  return Authority{std::move(inside)};
}

Result<Authority> Authority::open(const std::string& folder) {
  auto inside = std::make_unique<Inside>();
  inside->folder = folder;
  std::error_code error;
  if (!fs::is_directory(inside->folder / kFolder, error)) {
    if (fs::exists(inside->folder / kCertificate, error)) {
      const fs::path home =
          fs::absolute(inside->folder, error).lexically_normal().parent_path().parent_path();
      return Problem{folder, "this is the identity of one participant, not an authority",
                     fs::is_directory(home / kFolder, error)
                         ? "its authority is in " + home.string()
                         : "name the folder that takt secure init created"};
    }
    return Problem{folder, "this folder has no authority",
                   "create an authority with takt secure init CELL.xml " + folder};
  }
  Problems problems;
  const auto keep = [&problems](const Result<void>& result) {
    if (!result) problems.insert(problems.end(), result.problems().begin(), result.problems().end());
  };
  keep(read_into(inside->identity_key, inside->own(kIdentityKey), key_from));
  keep(read_into(inside->identity, inside->own(kIdentityAuthority), certificate_from));
  keep(read_into(inside->access_key, inside->own(kAccessKey), key_from));
  keep(read_into(inside->access, inside->own(kAccessAuthority), certificate_from));
  keep(read_into(inside->crl, inside->own(kRevoked), crl_from));
  if (!problems.empty()) return problems;
  const std::string name = subject_text(*inside->identity);
  const std::size_t at = name.find(",O=");
  if (at != std::string::npos) inside->cell = name.substr(at + 3);
  return Authority{std::move(inside)};
}

Result<std::string> Authority::descriptor() const { return read_authority_file(inside_->own(kDescriptor)); }

Result<int> Authority::domain() const {
  auto text = read_authority_file(inside_->own(kDomain));
  if (!text) return text.problems();
  int domain = -1;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), domain);
  if (error != std::errc{} || domain < 0)
    return Problem{inside_->own(kDomain).string(), "it does not contain the number of a DDS domain",
                   "restore it from a backup"};
  return domain;
}

Result<void> Authority::keep(const std::string& descriptor, int domain) {
  Files files{inside_->folder / kFolder};
  return files.write(kDescriptor, descriptor).write(kDomain, std::to_string(domain) + "\n").result();
}

Result<void> Authority::issue(const Subject& subject, const Plan& plan, int days, std::int64_t now,
                              bool again) {
  const fs::path folder = inside_->of(subject);
  std::error_code error;
  if (!again && fs::exists(folder, error)) {
    return Problem{folder.string(), "this identity already exists",
                   "use takt secure renew " + inside_->folder.string() + " " + subject.name + " to renew it"};
  }
  for (const Subject& other : named(subject.name)) {
    if (other.role != subject.role)
      return fail(
          std::string{to_text(other.role)} + " " + subject.name + " already has this name",
          "give each identity a different name, because takt secure renew and revoke take only a name");
  }
  const std::int64_t until = std::min(now + days * kDay, valid_until(*inside_->identity));
  const Key key = make_key();
  const Certificate certificate = make_certificate(Kind::identity, subject, *key, inside_->identity.get(),
                                                   *inside_->identity_key, {now - kBefore, until});
  if (auto made = os::make_private_folder(folder.parent_path().string()); !made) return made.problems();
  Files files{folder};
  files.write(kPrivateKey, to_pem(*key)).write(kCertificate, to_pem(*certificate));
  inside_->write_documents(files, subject, plan, now, until);
  return files.result();
}

Result<std::string> Authority::sign_components(const std::vector<std::string>& files, std::int64_t now) {
  std::error_code error;
  if (!fs::exists(inside_->own(kComponentsKey), error)) {
    const Key made = make_key();
    const Certificate certificate =
        make_certificate(Kind::authority, {inside_->cell, {}, "components"}, *made, nullptr, *made,
                         {now - kBefore, now + kAuthorityDays * kDay});
    Files own{inside_->folder / kFolder};
    own.write(kComponents, to_pem(*certificate)).write(kComponentsKey, to_pem(*made));
    if (!own.result()) return own.result().problems();
  }
  const auto key = read_authority_file(inside_->own(kComponentsKey));
  if (!key) return key.problems();
  Problems problems;
  for (const std::string& file : files) {
    if (auto signed_one = sign_file(file, *key); !signed_one)
      problems.insert(problems.end(), signed_one.problems().begin(), signed_one.problems().end());
  }
  if (!problems.empty()) return problems;
  return inside_->own(kComponents).string();
}

std::vector<Member> Authority::members(std::int64_t now) const {
  std::vector<Member> all;
  for (const Role role : kRoles) {
    std::error_code error;
    std::vector<Member> some;
    for (const auto& entry : fs::directory_iterator{inside_->folder / folder_name(role), error}) {
      Member member{.subject = {inside_->cell, role, entry.path().filename().string()},
                    .folder = entry.path().string()};
      Certificate certificate;
      if (auto found = read_into(certificate, entry.path() / kCertificate, certificate_from); found) {
        member.until = valid_until(*certificate);
        member.revoked = is_revoked(*inside_->crl, *certificate);
      }
      if (auto identity = read_identity(member.folder, now); !identity && !member.revoked)
        member.problems = identity.problems();
      some.push_back(std::move(member));
    }
    std::sort(some.begin(), some.end(),
              [](const Member& a, const Member& b) { return a.subject.name < b.subject.name; });
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

std::vector<Subject> Authority::named(const std::string& name) const {
  std::vector<Subject> all;
  for (const Role role : kRoles) {
    const Subject subject{inside_->cell, role, name};
    std::error_code error;
    if (fs::exists(inside_->of(subject), error)) all.push_back(subject);
  }
  return all;
}

Result<void> Authority::document(const Plan& plan, std::int64_t now) {
  for (const Member& member : members(now)) {
    Files files{member.folder};
    inside_->write_documents(files, member.subject, plan, now, member.until);
    if (!files.result()) return files.result();
  }
  return {};
}

Result<void> Authority::revoke(const Subject& subject, std::int64_t now) {
  Certificate certificate;
  if (auto found = read_into(certificate, inside_->of(subject) / kCertificate, certificate_from); !found)
    return found;
  if (is_revoked(*inside_->crl, *certificate))
    return Problem{inside_->of(subject).string(), "this identity is already revoked", ""};
  inside_->crl = make_crl(inside_->crl.get(), certificate.get(), *inside_->identity, *inside_->identity_key,
                          now - kBefore);
  Files own{inside_->folder / kFolder};
  own.write(kRevoked, to_pem(*inside_->crl));
  if (!own.result()) return own.result();
  for (const Member& member : members(now)) {
    Files files{member.folder};
    files.write(kRevoked, to_pem(*inside_->crl));
    if (!files.result()) return files.result();
  }
  return {};
}

}  // namespace takt::security
