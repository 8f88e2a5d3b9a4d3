#include <takt/client/identity.hpp>

#include <gmock/gmock.h>

#include <takt/os/clock.hpp>

namespace takt::client::identity_test {
namespace {

class Known final : public dds::Participant {
 public:
  explicit Known(std::optional<security::Identity> identity) : identity_(std::move(identity)) {}
  [[nodiscard]] const std::optional<security::Identity>& identity() const noexcept override {
    return identity_;
  }
  [[nodiscard]] std::uint64_t refused() const noexcept override { return 0; }
  [[nodiscard]] std::string unresolved() const override { return {}; }
  [[nodiscard]] std::vector<Announced> announced() const override { return {}; }
  [[nodiscard]] std::string obstacle(const std::string&) const override { return {}; }
  [[nodiscard]] std::string rejection_of(const std::string&) const override { return {}; }

 private:
  std::optional<security::Identity> identity_;
};

Known anna(std::int64_t until) {
  return Known{security::Identity{.subject = {"belt", security::Role::operator_, "anna"},
                                  .authority = {},
                                  .folder = "keys/operators/anna",
                                  .until = until,
                                  .domains = {}}};
}

TEST(CheckedIdentity, IsAcceptedUntilItExpires) {
  const std::int64_t now = os::wall_ns() / 1'000'000'000;
  EXPECT_TRUE(check_identity(Known{std::nullopt}).ok());
  EXPECT_TRUE(check_identity(anna(now + 3600)).ok());
  EXPECT_FALSE(check_identity(anna(now)).ok());
}

TEST(CheckedIdentity, IsNamedWithItsEndAndItsRemedyIfItHasExpired) {
  EXPECT_EQ(
      to_text(check_identity(anna(1'700'000'000)).problems()),
      "keys/operators/anna: error: nodes no longer accept the identity of operator anna: it expired on "
      "2023-11-14 at 22:13:20 UTC; run takt secure renew DIR anna, copy its folder again and restart this "
      "program");
}

}  // namespace
}  // namespace takt::client::identity_test
