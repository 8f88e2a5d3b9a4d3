#include <takt/security/authority.hpp>

#include <filesystem>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>

#include <takt/os/environment.hpp>
#include <takt/os/files.hpp>
#include <takt/security/choice.hpp>
#include <takt/security/revocations.hpp>

namespace authority_test {
namespace {

using namespace takt;
using namespace takt::security;
namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::SizeIs;

constexpr std::int64_t kNow = 1'800'000'000;
constexpr std::int64_t kDay = 24 * 3600;

std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream{path}.rdbuf();
  return text.str();
}
void write(const fs::path& path, const std::string& text) { std::ofstream{path} << text; }

/// A folder "home" with an authority that has issued an identity for device robot and one for operator anna.
class SigningAuthority : public testing::Test {
 protected:
  SigningAuthority() {
    fs::remove_all(folder_);
    plan_.cell.name = "belt";
    for (const char* name : {"robot", "line"}) {
      plan_.cell.devices.emplace_back();
      plan_.cell.devices.back().name = name;
    }
    plan_.domain = 7;
    authority_.emplace(std::move(*Authority::create(home(), "belt", kNow)));
    EXPECT_TRUE(authority_->issue(robot_, plan_, 100, kNow).ok());
    EXPECT_TRUE(authority_->issue(anna_, plan_, 100, kNow).ok());
  }
  ~SigningAuthority() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string home() const { return (folder_ / "home").string(); }
  [[nodiscard]] std::string of_robot() const { return home() + "/devices/robot"; }
  [[nodiscard]] std::string of_anna() const { return home() + "/operators/anna"; }
  [[nodiscard]] std::string wrong_with_robot(std::int64_t now = kNow) const {
    const auto identity = read_identity(of_robot(), now);
    return identity ? "" : to_text(identity.problems());
  }

  fs::path folder_ =
      fs::path{testing::TempDir()} / ("takt-authority-test-" + std::to_string(os::process_id()));
  Plan plan_;
  Subject robot_{"belt", Role::device, "robot"};
  Subject anna_{"belt", Role::operator_, "anna"};
  std::optional<Authority> authority_;
};

TEST_F(SigningAuthority, RejectsAnIdentityWithAFileThatEverybodyMayWriteTo) {
  fs::permissions(of_robot(), fs::perms{0755});
  for (const char* file : {kIdentityAuthority, kAccessAuthority, kCertificate, kPrivateKey, kRevoked,
                           kGovernance, kPermissions}) {
    const fs::path path = fs::path{of_robot()} / file;
    const fs::perms before = fs::status(path).permissions();
    fs::permissions(path, fs::perms::others_write, fs::perm_options::add);
    EXPECT_THAT(wrong_with_robot(), HasSubstr("everybody may write to " + path.string() + " "));
    fs::permissions(path, before);
  }
  EXPECT_EQ(wrong_with_robot(), "");
}

TEST_F(SigningAuthority, DoesNotOpenWithAKeyThatEverybodyMayReplace) {
  const fs::path own = fs::path{home()} / "authority";
  fs::permissions(own, fs::perms{0777});
  const auto opened = Authority::open(home());
  ASSERT_FALSE(opened.ok());
  EXPECT_THAT(to_text(opened.problems()), HasSubstr("everybody may write to " + own.string() + " "));
}

TEST_F(SigningAuthority, IssuesAValidIdentityFolder) {
  const auto identity = read_identity(of_robot(), kNow);
  ASSERT_TRUE(identity.ok()) << to_text(identity.problems());
  EXPECT_EQ(identity->subject, robot_);
  EXPECT_EQ(identity->until, kNow + 100 * kDay);
  EXPECT_THAT(identity->domains, testing::ElementsAre(7));
}

bool names_somebody(const std::string& certificate) {
  return security::names_somebody(
      {reinterpret_cast<const std::uint8_t*>(certificate.data()), certificate.size()});
}

TEST_F(SigningAuthority, AcceptsOnlyCertificatesWithASubject) {
  EXPECT_TRUE(names_somebody(text_of(of_robot() + "/identity.cert.pem")));
  EXPECT_TRUE(names_somebody(text_of(of_robot() + "/ca.cert.pem")));
  EXPECT_FALSE(names_somebody(text_of(of_robot() + "/identity.key.pem")));
  EXPECT_FALSE(names_somebody(""));
  EXPECT_FALSE(names_somebody("-----BEGIN CERTIFICATE-----\n"));
  EXPECT_FALSE(names_somebody(std::string(1 << 20, 'x')));
  // a certificate without a subject, made with: openssl req -x509 -new -key KEY -subj /
  EXPECT_FALSE(
      names_somebody("-----BEGIN CERTIFICATE-----\n"
                     "MIIBVjCB/aADAgECAhRwAfNWhBHvEH2j56FxhISaMIDkfjAKBggqhkjOPQQDAjAA\n"
                     "MCAXDTI2MTEyMzA3NDAyNVoYDzIxMjYxMDMwMDc0MDI1WjAAMFkwEwYHKoZIzj0C\n"
                     "AQYIKoZIzj0DAQcDQgAEWqPxPG5GnHQOCJqEE9QgjcXjnPlSTHHtGA2sdl04Q7iJ\n"
                     "2nww2kElOLbz4FHeVu1ghmSeXD2CEgnbZQj92OBQe6NTMFEwHQYDVR0OBBYEFPnH\n"
                     "PjHyR+mdg5DkKjLQauc/JcdLMB8GA1UdIwQYMBaAFPnHPjHyR+mdg5DkKjLQauc/\n"
                     "JcdLMA8GA1UdEwEB/wQFMAMBAf8wCgYIKoZIzj0EAwIDSAAwRQIhAOJxvdR0meh3\n"
                     "YLj6wxk6kdXR+sdCgQOGoufDVhpo75wYAiBtDeOq6ec3si2oAys2/1Ey0HFJy3SH\n"
                     "vgqEOfpeyQGV8Q==\n"
                     "-----END CERTIFICATE-----\n"));
}

TEST_F(SigningAuthority, LetsOnlyTheOwnerReadItsFiles) {
  for (const auto& entry : fs::recursive_directory_iterator{home()}) {
    EXPECT_EQ(entry.status().permissions() & (fs::perms::group_all | fs::perms::others_all), fs::perms::none)
        << entry.path();
  }
}

TEST_F(SigningAuthority, RejectsAKeyThatOthersMayRead) {
  fs::permissions(of_robot() + "/identity.key.pem", fs::perms::group_read, fs::perm_options::add);
  EXPECT_THAT(wrong_with_robot(), HasSubstr("chmod 600 " + of_robot() + "/identity.key.pem"));
}

TEST_F(SigningAuthority, RejectsAnIdentityInAFolderThatEverybodyMayWriteTo) {
  fs::permissions(of_robot(), fs::perms::all);
  EXPECT_THAT(wrong_with_robot(), HasSubstr("everybody may write to " + of_robot() + " "));
}

TEST_F(SigningAuthority, IsNeverOverwritten) {
  const std::string key = text_of(home() + "/authority/ca.key.pem");
  const auto again = Authority::create(home(), "belt", kNow);
  ASSERT_FALSE(again.ok());
  EXPECT_THAT(again.problems()[0].what, HasSubstr("already"));
  EXPECT_EQ(text_of(home() + "/authority/ca.key.pem"), key);
  EXPECT_FALSE(authority_->issue(robot_, plan_, 100, kNow).ok()) << "an identity is not overwritten either";
  const auto same_name = authority_->issue({"belt", Role::operator_, "robot"}, plan_, 100, kNow);
  ASSERT_FALSE(same_name.ok());
  EXPECT_EQ(same_name.problems()[0].what, "device robot already has this name");
}

TEST_F(SigningAuthority, CanBeOpenedAgain) {
  auto again = Authority::open(home());
  ASSERT_TRUE(again.ok()) << to_text(again.problems());
  EXPECT_EQ(again->cell(), "belt");
  ASSERT_TRUE(again->issue({"belt", Role::observer, "eve"}, plan_, 10, kNow).ok());
  EXPECT_TRUE(read_identity(home() + "/observers/eve", kNow).ok());
  EXPECT_THAT(again->members(kNow), SizeIs(3));
}

TEST_F(SigningAuthority, IssuesAnIdentityThatIsValidOnlyForTheRequestedDays) {
  EXPECT_EQ(wrong_with_robot(kNow + 100 * kDay - 60), "");
  EXPECT_THAT(wrong_with_robot(kNow + 100 * kDay + 60), HasSubstr("it has expired"));
  EXPECT_EQ(wrong_with_robot(kNow - 600), "") << "valid before it was issued, because clocks differ";
  EXPECT_THAT(wrong_with_robot(kNow - 2 * kDay), HasSubstr("not valid yet"));
}

TEST_F(SigningAuthority, NeverIssuesAnIdentityThatIsValidLongerThanItself) {
  ASSERT_TRUE(authority_->issue({"belt", Role::operator_, "old"}, plan_, 3650, kNow + 3000 * kDay).ok());
  EXPECT_EQ(read_identity(home() + "/operators/old", kNow + 3000 * kDay)->until, kNow + 3650 * kDay);
}

TEST_F(SigningAuthority, CreatesANewKeyWhenItRenewsAnIdentity) {
  const std::string key = text_of(of_robot() + "/identity.key.pem");
  ASSERT_TRUE(authority_->issue(robot_, plan_, 200, kNow, true).ok());
  EXPECT_NE(text_of(of_robot() + "/identity.key.pem"), key);
  EXPECT_EQ(read_identity(of_robot(), kNow)->until, kNow + 200 * kDay);
}

TEST_F(SigningAuthority, WritesARevocationToTheFoldersOfAllIdentities) {
  ASSERT_TRUE(authority_->revoke(robot_, kNow).ok());
  EXPECT_THAT(wrong_with_robot(), HasSubstr("revoked"));
  EXPECT_TRUE(read_identity(of_anna(), kNow).ok());
  EXPECT_EQ(text_of(of_anna() + "/crl.pem"), text_of(of_robot() + "/crl.pem"));
  EXPECT_FALSE(authority_->revoke(robot_, kNow).ok()) << "cannot be revoked twice";
  ASSERT_TRUE(Authority::open(home())->revoke(anna_, kNow).ok());
  EXPECT_THAT(wrong_with_robot(), HasSubstr("revoked")) << "the first identity is still on the list";
  ASSERT_TRUE(Authority::open(home())->issue(robot_, plan_, 10, kNow, true).ok());
  EXPECT_EQ(wrong_with_robot(), "") << "the new certificate is not on the list";
}

TEST_F(SigningAuthority, ShowsARunningProcessEachNewListOfRevocations) {
  const std::string anna = read_identity(of_anna(), kNow)->serial;
  const std::string robot = read_identity(of_robot(), kNow)->serial;
  Revocations list{of_robot()};
  EXPECT_TRUE(list.update().ok());
  EXPECT_FALSE(list.contains(anna));
  ASSERT_TRUE(authority_->revoke(anna_, kNow).ok());
  EXPECT_TRUE(list.update().ok());
  EXPECT_TRUE(list.contains(anna));
  EXPECT_FALSE(list.contains(robot));
}

TEST_F(SigningAuthority, KeepsTheListOfRevocationsIfItsFileIsMissingOrWasNotSigned) {
  const std::string anna = read_identity(of_anna(), kNow)->serial;
  ASSERT_TRUE(authority_->revoke(anna_, kNow).ok());
  Revocations list{of_robot()};
  EXPECT_TRUE(list.update().ok());
  const auto problems = [&list] {
    int count = 0;
    for (int i = 0; i < 3 * Revocations::kTries; ++i) count += list.update().ok() ? 0 : 1;
    return count;
  };
  fs::remove(of_robot() + "/crl.pem");
  EXPECT_EQ(problems(), 0);
  write(of_robot() + "/crl.pem", "nonsense");
  EXPECT_EQ(problems(), 1) << "reported once";
  auto other = Authority::create((folder_ / "other").string(), "belt", kNow);
  ASSERT_TRUE(other->issue(robot_, plan_, 100, kNow).ok());
  write(of_robot() + "/crl.pem", text_of(folder_ / "other/devices/robot/crl.pem"));
  EXPECT_EQ(problems(), 1) << "another authority has signed it";
  EXPECT_TRUE(list.contains(anna));
}

TEST_F(SigningAuthority, NamesAMissingOrInvalidFile) {
  for (const char* file : {"ca.cert.pem", "permissions.cert.pem", "identity.cert.pem", "identity.key.pem",
                           "governance.smime", "permissions.smime", "crl.pem"}) {
    const std::string path = of_robot() + "/" + file;
    const std::string content = text_of(path);
    fs::remove(path);
    EXPECT_THAT(wrong_with_robot(), HasSubstr(path + ": error: there is no such file")) << file;
    write(path, "nonsense");
    fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write);
    EXPECT_THAT(wrong_with_robot(), HasSubstr(path + ": error: it")) << file;
    write(path, content);
  }
  EXPECT_EQ(wrong_with_robot(), "");
  EXPECT_FALSE(read_identity(home() + "/devices/nobody", kNow).ok());
}

TEST_F(SigningAuthority, RejectsTheKeyOfAnotherIdentity) {
  write(of_robot() + "/identity.key.pem", text_of(of_anna() + "/identity.key.pem"));
  EXPECT_THAT(wrong_with_robot(), HasSubstr("this key does not belong to identity.cert.pem"));
}

TEST_F(SigningAuthority, RejectsThePermissionsOfAnotherIdentity) {
  write(of_robot() + "/permissions.smime", text_of(of_anna() + "/permissions.smime"));
  EXPECT_THAT(wrong_with_robot(), HasSubstr("not for CN=robot,OU=device,O=belt"));
}

TEST_F(SigningAuthority, RejectsAChangedDocument) {
  std::string text = text_of(of_robot() + "/permissions.smime");
  text.replace(text.find("takt/lifecycle"), 14, "takt/*        ");
  write(of_robot() + "/permissions.smime", text);
  EXPECT_THAT(wrong_with_robot(), HasSubstr("its signature was not made by the authority"));
}

TEST_F(SigningAuthority, RejectsFilesOfAnotherAuthority) {
  auto evil = Authority::create((folder_ / "evil").string(), "belt", kNow);
  ASSERT_TRUE(evil->issue(robot_, plan_, 100, kNow).ok());
  const std::string theirs = (folder_ / "evil/devices/robot/").string();
  for (const char* file : {"identity.cert.pem", "identity.key.pem"})
    write(of_robot() + "/" + file, text_of(theirs + file));
  EXPECT_THAT(wrong_with_robot(), HasSubstr("it was issued by another authority"));
  write(of_robot() + "/governance.smime", text_of(theirs + "governance.smime"));
  EXPECT_THAT(wrong_with_robot(), HasSubstr("governance.smime: error: its signature"));
  write(of_robot() + "/crl.pem", text_of(theirs + "crl.pem"));
  EXPECT_THAT(wrong_with_robot(), HasSubstr("crl.pem: error: its signature"));
}

TEST_F(SigningAuthority, UpdatesTheDocumentsOfAllIdentities) {
  const std::string before = text_of(of_robot() + "/permissions.smime");
  plan_.domain = 9;
  ASSERT_TRUE(authority_->document(plan_, kNow).ok());
  EXPECT_THAT(read_identity(of_robot(), kNow)->domains, testing::ElementsAre(9));
  EXPECT_THAT(read_identity(of_anna(), kNow)->domains, testing::ElementsAre(9));
}

TEST_F(SigningAuthority, StoresTheDescriptorAndTheDomain) {
  EXPECT_FALSE(authority_->descriptor().ok());
  ASSERT_TRUE(authority_->keep("<cell/>", 7).ok());
  EXPECT_EQ(*Authority::open(home())->descriptor(), "<cell/>");
  EXPECT_EQ(*Authority::open(home())->domain(), 7);
}

TEST_F(SigningAuthority, FindsTheFolderOfAnIdentity) {
  EXPECT_EQ(folder_of(home(), Role::device, "robot"), of_robot());
  EXPECT_EQ(first_of(home(), Role::operator_, kNow).folder, of_anna());
  EXPECT_EQ(folder_of(of_robot(), Role::device, "robot"), of_robot());
  EXPECT_EQ(first_of(of_anna(), Role::operator_, kNow).folder, of_anna());
}

TEST_F(SigningAuthority, SkipsARevokedOperatorWhenAnIdentityIsChosen) {
  const Subject bert{"belt", Role::operator_, "bert"};
  ASSERT_TRUE(authority_->issue(bert, plan_, 100, kNow).ok());
  EXPECT_THAT(first_of(home(), Role::operator_, kNow).passed_over, SizeIs(0));
  ASSERT_TRUE(authority_->revoke(anna_, kNow).ok());
  const Chosen chosen = first_of(home(), Role::operator_, kNow);
  EXPECT_EQ(chosen.folder, home() + "/operators/bert");
  EXPECT_THAT(to_text(chosen.passed_over), HasSubstr("anna/identity.cert.pem: error: it was revoked"));
  ASSERT_TRUE(authority_->revoke(bert, kNow).ok());
  EXPECT_EQ(first_of(home(), Role::operator_, kNow).folder, of_anna()) << "no identity is valid";
}

TEST_F(SigningAuthority, RejectsTheFolderOfAnIdentityAsAnAuthority) {
  const auto wrong = Authority::open(of_anna());
  ASSERT_FALSE(wrong.ok());
  EXPECT_THAT(to_text(wrong.problems()),
              HasSubstr("this is the identity of one participant, not an authority; "
                        "its authority is in " +
                        home()));
}

TEST(Expiry, WarnsInTheLastThirtyDays) {
  EXPECT_EQ(expiry_warning(kNow + 31 * kDay, kNow), "");
  EXPECT_EQ(expiry_warning(kNow + 29 * kDay + 60, kNow), "it expires in 29 days");
  EXPECT_EQ(expiry_warning(kNow + 60, kNow), "it expires within a day");
  EXPECT_EQ(expiry_warning(1'700'000'000, 1'700'000'000), "it expired on 2023-11-14 at 22:13:20 UTC");
}

TEST(ParticipantPrefix, DiffersBetweenSubjects) {
  const Prefix robot = prefix_of({"belt", Role::device, "robot"});
  EXPECT_EQ(robot, prefix_of({"belt", Role::device, "robot"}));
  EXPECT_NE(robot, prefix_of({"belt", Role::operator_, "robot"}));
  EXPECT_NE(robot, prefix_of({"belt", Role::device, "line"}));
  EXPECT_EQ(robot[0] & 0x80, 0x80) << "the first bit is set, as DDS Security requires";
}

}  // namespace
}  // namespace authority_test
