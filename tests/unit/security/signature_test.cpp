#include <takt/security/signature.hpp>

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>

#include <takt/os/environment.hpp>
#include <takt/os/sealed_copy.hpp>
#include <takt/security/authority.hpp>

namespace signature_test {
namespace {

using namespace takt;
using namespace takt::security;
namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

constexpr std::int64_t kNow = 1'800'000'000;
constexpr std::int64_t kYear = std::int64_t{365} * 24 * 3600;

class SignatureCheck : public testing::Test {
 protected:
  SignatureCheck() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    std::ofstream{file_} << "a component";
    auto authority = Authority::create((folder_ / "home").string(), "belt", kNow);
    certificate_ = *authority->sign_components({file_}, kNow);
  }
  ~SignatureCheck() override { fs::remove_all(folder_); }
  [[nodiscard]] std::string wrong(std::int64_t now = kNow) const {
    const auto copy = os::sealed_copy(file_);
    const auto checked = check_signature(file_, *copy, certificate_, now);
    return checked ? "" : to_text(checked.problems());
  }

  fs::path folder_ =
      fs::path{testing::TempDir()} / ("takt-signature-test-" + std::to_string(os::process_id()));
  std::string file_ = (folder_ / "servo.so").string();
  std::string certificate_;
};

TEST_F(SignatureCheck, AcceptsTheSignedFile) { EXPECT_EQ(wrong(), ""); }

TEST_F(SignatureCheck, RejectsAChangedFile) {
  std::ofstream{file_, std::ios::app} << "!";
  EXPECT_THAT(wrong(), HasSubstr("its signature does not match its contents"));
}

TEST_F(SignatureCheck, ChecksTheGivenCopyInsteadOfTheFile) {
  const auto copy = os::sealed_copy(file_);
  std::ofstream{file_, std::ios::app} << "!";
  EXPECT_TRUE(check_signature(file_, *copy, certificate_, kNow).ok());
  const auto changed = os::sealed_copy(file_);
  std::ofstream{file_} << "a component";
  EXPECT_FALSE(check_signature(file_, *changed, certificate_, kNow).ok());
}

TEST_F(SignatureCheck, RejectsTheSignatureOfAnotherFile) {
  std::ofstream{folder_ / "other.so"} << "another";
  auto authority = Authority::open((folder_ / "home").string());
  ASSERT_TRUE(authority->sign_components({(folder_ / "other.so").string()}, kNow).ok());
  fs::rename(folder_ / "other.so.sig", file_ + ".sig");
  EXPECT_THAT(wrong(), HasSubstr("its signature does not match its contents"));
}

TEST_F(SignatureCheck, RejectsTheSignatureOfAnotherAuthority) {
  auto evil = Authority::create((folder_ / "evil").string(), "belt", kNow);
  ASSERT_TRUE(evil->sign_components({file_}, kNow).ok());
  EXPECT_THAT(wrong(), HasSubstr("or was not made with the key of " + certificate_));
}

TEST_F(SignatureCheck, RequiresAValidSignerCertificate) {
  const auto wrong_signer = [](const std::string& file, std::int64_t now = kNow) {
    const auto checked = check_signer(file, now);
    return checked ? "" : to_text(checked.problems());
  };
  EXPECT_EQ(wrong_signer(certificate_), "");
  EXPECT_THAT(wrong_signer(certificate_ + ".no"),
              HasSubstr(".no: error: there is no such file; name the certi"));
  EXPECT_THAT(wrong_signer(file_), HasSubstr(file_ + ": error: it is not a certificate"));
  EXPECT_THAT(wrong_signer(certificate_, kNow + 11 * kYear), HasSubstr("it has expired"));
}

TEST_F(SignatureCheck, RejectsACertificateThatEverybodyMayWriteTo) {
  fs::permissions(certificate_, fs::perms::others_write, fs::perm_options::add);
  EXPECT_THAT(wrong(), HasSubstr("everybody may write to " + certificate_ + " "));
}

TEST_F(SignatureCheck, ReportsAMissingSignature) {
  fs::remove(file_ + ".sig");
  EXPECT_THAT(wrong(), HasSubstr("it is not signed, and only signed components are accepted here; sign it"));
  std::ofstream{file_ + ".sig"} << "nonsense";
  EXPECT_THAT(wrong(), HasSubstr("its signature does not match"));
}

TEST_F(SignatureCheck, FindsASignatureWrittenThroughALink) {
  fs::remove(file_ + ".sig");
  fs::create_symlink("current.sig", file_ + ".sig");
  fs::create_symlink("kept.sig", folder_ / "current.sig");
  for (const char* target : {"a new file", "an existing file"}) {
    ASSERT_TRUE(Authority::open((folder_ / "home").string())->sign_components({file_}, kNow).ok()) << target;
    EXPECT_TRUE(fs::is_symlink(file_ + ".sig")) << target;
    EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(folder_ / "kept.sig"))) << target;
    EXPECT_EQ(wrong(), "") << target;
  }
}

TEST_F(SignatureCheck, IsNotWrittenThroughALinkOfAnotherUserInASharedFolder) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give files to other users";
  ::unsetenv("SUDO_UID");
  ASSERT_EQ(::chmod(folder_.c_str(), 01777), 0);
  std::ofstream{folder_ / "victim"} << "a file of root";
  fs::remove(file_ + ".sig");
  fs::create_symlink("victim", file_ + ".sig");
  ASSERT_EQ(::lchown((file_ + ".sig").c_str(), 54321, 0), 0);
  const auto signed_file = Authority::open((folder_ / "home").string())->sign_components({file_}, kNow);
  ASSERT_FALSE(signed_file.ok());
  EXPECT_THAT(to_text(signed_file.problems()),
              AllOf(HasSubstr(file_ + ".sig: error: is a link that takt sign does not follow: "),
                    HasSubstr("belongs to user 54321"), HasSubstr("; remove the link")));
  EXPECT_EQ(fs::file_size(folder_ / "victim"), std::string{"a file of root"}.size());
}

TEST_F(SignatureCheck, FailsAfterTheCertificateHasExpired) {
  EXPECT_EQ(wrong(kNow + 9 * kYear), "");
  EXPECT_THAT(wrong(kNow + 11 * kYear), HasSubstr("it has expired"));
}

TEST_F(SignatureCheck, FailsIfTheFileOrTheCertificateIsMissing) {
  fs::remove(certificate_);
  EXPECT_THAT(wrong(), HasSubstr("there is no such file"));
  EXPECT_FALSE(sign_file((folder_ / "nothing").string(), "").ok());
  EXPECT_FALSE(sign_file(file_, "nonsense").ok());
}

}  // namespace
}  // namespace signature_test
