// The authority of a secured cell: a folder that stays at home. It issues identities, says what each may
// write and read, and takes identities back.
//
//   DIR/authority/               its two keys, what it has revoked, and the cell that permissions follow from
//   DIR/devices/NAME/            of one participant each, as security::read_identity() wants them: copied to
//   DIR/operators/NAME/          the machine that it is for
//   DIR/observers/NAME/
//   DIR/programs/NAME/
//
// One key signs identities and another one the documents. With one key for both, who has an identity could
// sign permissions for himself: his certificate too comes from the authority that documents are held against.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/security/identity.hpp>

namespace takt::security {

/// What permissions follow from.
struct Plan {
  model::Cell cell;
  int domain = 0;
};

struct Member {
  Subject subject;
  std::string folder;
  std::int64_t until = 0;  ///< seconds since 1970
  bool revoked = false;
  Problems problems{};  ///< with its folder
};

class Authority {
 public:
  /// A new one, for cells of this name. Fails where there is one already. `now`: seconds since 1970, here and
  /// below.
  static Result<Authority> create(const std::string& folder, const std::string& cell, std::int64_t now);
  static Result<Authority> open(const std::string& folder);
  Authority(Authority&&) noexcept;
  Authority& operator=(Authority&&) noexcept;
  ~Authority();

  [[nodiscard]] const std::string& cell() const noexcept;
  /// The descriptor that was kept, and the domain. Fails where there is none.
  [[nodiscard]] Result<std::string> descriptor() const;
  [[nodiscard]] Result<int> domain() const;
  Result<void> keep(const std::string& descriptor, int domain);

  /// A key, a certificate for `days` (1 to 3650, never longer than the authority's) and documents, in a
  /// folder of its own. With `again` in place of those that are there; else that fails.
  Result<void> issue(const Subject& subject, const Plan& plan, int days, std::int64_t now,
                     bool again = false);
  /// The documents of everybody anew.
  Result<void> document(const Plan& plan, std::int64_t now);
  /// The identity is worth nothing any more where the new crl.pem has been copied to and read: it is put into
  /// every folder.
  Result<void> revoke(const Subject& subject, std::int64_t now);
  /// Writes FILE.sig for each of these, with a key for components that is made when it is needed first;
  /// returns the path of its certificate, which goes to the nodes that are to ask for signatures.
  Result<std::string> sign_components(const std::vector<std::string>& files, std::int64_t now);
  /// Everybody who has a folder, by role and name.
  [[nodiscard]] std::vector<Member> members(std::int64_t now) const;
  /// Those of this name.
  [[nodiscard]] std::vector<Subject> named(const std::string& name) const;

 private:
  struct Inside;
  explicit Authority(std::unique_ptr<Inside> inside) noexcept;
  std::unique_ptr<Inside> inside_;
};

}  // namespace takt::security
