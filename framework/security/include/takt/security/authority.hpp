// The authority of a secured cell: a folder that never leaves its machine. It issues identities with
// permissions, and revokes them.
//
//   DIR/authority/               its two keys, the list of revoked identities, and the cell
//   DIR/devices/NAME/            one folder for each participant, as security::read_identity() needs it;
//   DIR/operators/NAME/          copied to the machine of the participant
//   DIR/observers/NAME/
//   DIR/programs/NAME/
//
// One key signs identities, another one the documents. With one key for both, the owner of any identity could
// sign permissions for it, because the authority that verifies documents would also have issued its
// certificate.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/security/identity.hpp>

namespace takt::security {

/// The cell and its domain, from which the permissions are derived.
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
  Problems problems{};  ///< of its folder
};

class Authority {
 public:
  /// Creates an authority for cells of this name. Fails if the folder already has one. Here and below, `now`
  /// is in seconds since 1970.
  static Result<Authority> create(const std::string& folder, const std::string& cell, std::int64_t now);
  static Result<Authority> open(const std::string& folder);
  Authority(Authority&&) noexcept;
  Authority& operator=(Authority&&) noexcept;
  ~Authority();

  [[nodiscard]] const std::string& cell() const noexcept;
  /// The descriptor and the domain that keep() has stored. Both functions fail if keep() has stored nothing.
  [[nodiscard]] Result<std::string> descriptor() const;
  [[nodiscard]] Result<int> domain() const;
  Result<void> keep(const std::string& descriptor, int domain);

  /// Issues an identity: a key, a certificate for `days` (1 to 3650, at most as long as the authority is
  /// valid) and the documents, in a folder of its own. Fails if the identity already exists. With `again`,
  /// replaces it instead.
  Result<void> issue(const Subject& subject, const Plan& plan, int days, std::int64_t now,
                     bool again = false);
  /// Writes new documents for all identities.
  Result<void> document(const Plan& plan, std::int64_t now);
  /// Revokes an identity and writes the new crl.pem into every folder. A machine rejects the identity after
  /// crl.pem has been copied there and read.
  Result<void> revoke(const Subject& subject, std::int64_t now);
  /// Writes FILE.sig for each file, with the authority's key for components. The first call creates this key.
  /// Returns the path of the key's certificate, for the nodes that require signatures.
  Result<std::string> sign_components(const std::vector<std::string>& files, std::int64_t now);
  /// All identities that have a folder, by role and name.
  [[nodiscard]] std::vector<Member> members(std::int64_t now) const;
  /// The identities of this name, at most one for each role.
  [[nodiscard]] std::vector<Subject> named(const std::string& name) const;

 private:
  struct Inside;
  explicit Authority(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::security
