// The authority of a secured cell. The authority issues identities with permissions, and revokes them. It
// consists of a folder, DIR, whose subfolder `authority` must never leave its machine.
//
//   DIR/authority/               its two keys, the list of revoked identities, and the cell
//   DIR/devices/NAME/            one folder for each participant, as security::read_identity() needs it;
//   DIR/operators/NAME/          copied to the machine of the participant
//   DIR/observers/NAME/
//   DIR/programs/NAME/
//
// One key signs identities, the other key signs documents. Fast DDS accepts a document if the authority for
// documents has issued the certificate of the document's signer. So if one key did both, the owner of any
// identity could sign permissions for this identity.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/security/identity.hpp>

namespace takt::security {

/// The cell and its domain, from which the authority derives the permissions.
struct Plan {
  model::Cell cell;
  int domain = 0;
};

/// A participant with an identity.
struct Member {
  Subject subject;
  std::string folder;
  std::int64_t until = 0;  ///< end of validity, in seconds since 1970
  bool revoked = false;
  Problems problems{};  ///< the problems of the files in `folder`
};

class Authority {
 public:
  /// Creates an authority for cells with the name `cell`. Fails if the folder already contains an authority.
  /// In all functions of this class, `now` is in seconds since 1970.
  static Result<Authority> create(const std::string& folder, const std::string& cell, std::int64_t now);
  static Result<Authority> open(const std::string& folder);
  Authority(Authority&&) noexcept;
  Authority& operator=(Authority&&) noexcept;
  ~Authority();

  [[nodiscard]] const std::string& cell() const noexcept;
  /// descriptor() and domain() return what keep() has stored. They fail if keep() has stored nothing.
  [[nodiscard]] Result<std::string> descriptor() const;
  [[nodiscard]] Result<int> domain() const;
  Result<void> keep(const std::string& descriptor, int domain);

  /// Issues an identity: creates a folder with a key, a certificate and the documents. The certificate is
  /// valid for `days`, from 1 to 3650, but at most as long as the authority's own certificate. If the
  /// identity already exists, issue() replaces it if `again` is true, and otherwise fails.
  Result<void> issue(const Subject& subject, const Plan& plan, int days, std::int64_t now,
                     bool again = false);
  /// Writes new governance and permissions documents for all identities.
  Result<void> document(const Plan& plan, std::int64_t now);
  /// Revokes an identity and writes the new crl.pem into every folder. Processes read it as soon as it is
  /// copied to their machine, and then reject the revoked identity.
  Result<void> revoke(const Subject& subject, std::int64_t now);
  /// Signs each file with the authority's key for components, and writes the signature to FILE.sig. The first
  /// call creates this key. Returns the path of the certificate for this key. Nodes check the signatures with
  /// this certificate.
  Result<std::string> sign_components(const std::vector<std::string>& files, std::int64_t now);
  /// Returns all identities that have a folder below DIR, sorted by role and name.
  [[nodiscard]] std::vector<Member> members(std::int64_t now) const;
  /// Returns the identities with this name, at most one for each role.
  [[nodiscard]] std::vector<Subject> named(const std::string& name) const;

 private:
  struct Inside;
  explicit Authority(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::security
