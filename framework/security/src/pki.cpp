#include "pki.hpp"

#include <array>
#include <ctime>
#include <limits>

#include <openssl/asn1.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/rand.h>
#include <openssl/x509_vfy.h>
#include <openssl/x509v3.h>

#include <takt/core/check.hpp>
#include <takt/security/identity.hpp>

namespace takt::security {

namespace {

using Name = std::unique_ptr<X509_NAME, FreedBy<X509_NAME_free>>;
using Time = std::unique_ptr<ASN1_TIME, FreedBy<ASN1_TIME_free>>;
using Number = std::unique_ptr<ASN1_INTEGER, FreedBy<ASN1_INTEGER_free>>;
using Large = std::unique_ptr<BIGNUM, FreedBy<BN_free>>;
using Store = std::unique_ptr<X509_STORE, FreedBy<X509_STORE_free>>;
using StoreContext = std::unique_ptr<X509_STORE_CTX, FreedBy<X509_STORE_CTX_free>>;
using Pkcs7 = std::unique_ptr<PKCS7, FreedBy<PKCS7_free>>;
using Extension = std::unique_ptr<X509_EXTENSION, FreedBy<X509_EXTENSION_free>>;

constexpr int kSerialBytes = 16;
constexpr std::size_t kLargestCertificate = 65536;  // bytes of PEM text

void add_part(X509_NAME& name, const char* part, const std::string& value) {
  // The encoding must never vary, because the GUID of a participant on DDS contains a hash of these bytes.
  TAKT_CHECK(X509_NAME_add_entry_by_txt(&name, part, V_ASN1_UTF8STRING,
                                        reinterpret_cast<const unsigned char*>(value.data()),
                                        static_cast<int>(value.size()), -1, 0) == 1);
}

Name name_of(const Subject& subject) {
  Name name{X509_NAME_new()};
  add_part(*name, "O", subject.cell);
  add_part(*name, "OU", to_text(subject.role));
  add_part(*name, "CN", subject.name);
  return name;
}

Time time_of(std::int64_t seconds) { return Time{ASN1_TIME_set(nullptr, static_cast<std::time_t>(seconds))}; }

Number new_serial() {
  std::array<unsigned char, kSerialBytes> bytes{};
  TAKT_CHECK(RAND_bytes(bytes.data(), kSerialBytes) == 1);
  bytes[0] &= 0x7f;
  const Large large{BN_bin2bn(bytes.data(), kSerialBytes, nullptr)};
  return Number{BN_to_ASN1_INTEGER(large.get(), nullptr)};
}

void extend(X509& certificate, X509& issuer, int what, const char* value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, &issuer, &certificate, nullptr, nullptr, 0);
  const Extension extension{X509V3_EXT_conf_nid(nullptr, &context, what, value)};
  TAKT_CHECK(extension != nullptr && X509_add_ext(&certificate, extension.get(), -1) == 1);
}

std::string to_hex(const ASN1_INTEGER& serial) {
  const Large large{ASN1_INTEGER_to_BN(&serial, nullptr)};
  char* const text = BN_bn2hex(large.get());
  std::string digits = text;
  OPENSSL_free(text);
  return digits;
}

}  // namespace

std::string openssl_reason() {
  std::array<char, 256> text{};
  const unsigned long code = ERR_get_error();
  ERR_clear_error();
  if (code == 0) return "OpenSSL gave no reason";
  ERR_error_string_n(code, text.data(), text.size());
  return text.data();
}

Bytes bytes_of(std::string_view text) {
  TAKT_CHECK(text.size() <= static_cast<std::size_t>(std::numeric_limits<int>::max()));
  return Bytes{BIO_new_mem_buf(text.data(), static_cast<int>(text.size()))};
}
Bytes no_bytes() { return Bytes{BIO_new(BIO_s_mem())}; }
std::string text_of(BIO& bytes) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(&bytes, &data);
  return size <= 0 ? std::string{} : std::string{data, static_cast<std::size_t>(size)};
}

Key make_key() {
  Key key{EVP_EC_gen("P-256")};
  TAKT_CHECK(key != nullptr);
  return key;
}

Key key_from(std::string_view pem) {
  // Prevent OpenSSL from asking for a password. Takt does not create keys with a password.
  const auto no_password = [](char*, int, int, void*) { return 0; };
  Key key{PEM_read_bio_PrivateKey(bytes_of(pem).get(), nullptr, no_password, nullptr)};
  ERR_clear_error();
  return key;
}
Certificate certificate_from(std::string_view pem) {
  Certificate certificate{PEM_read_bio_X509(bytes_of(pem).get(), nullptr, nullptr, nullptr)};
  ERR_clear_error();
  return certificate;
}
Crl crl_from(std::string_view pem) {
  Crl crl{PEM_read_bio_X509_CRL(bytes_of(pem).get(), nullptr, nullptr, nullptr)};
  ERR_clear_error();
  return crl;
}

std::string to_pem(EVP_PKEY& key) {
  const Bytes out = no_bytes();
  TAKT_CHECK(PEM_write_bio_PrivateKey(out.get(), &key, nullptr, nullptr, 0, nullptr, nullptr) == 1);
  return text_of(*out);
}
std::string to_pem(X509& certificate) {
  const Bytes out = no_bytes();
  TAKT_CHECK(PEM_write_bio_X509(out.get(), &certificate) == 1);
  return text_of(*out);
}
std::string to_pem(X509_CRL& crl) {
  const Bytes out = no_bytes();
  TAKT_CHECK(PEM_write_bio_X509_CRL(out.get(), &crl) == 1);
  return text_of(*out);
}

std::int64_t valid_until(const X509& certificate) {
  std::tm parts{};
  if (ASN1_TIME_to_tm(X509_get0_notAfter(&certificate), &parts) != 1) return 0;
  return static_cast<std::int64_t>(::timegm(&parts));
}

std::string subject_text(const X509& certificate) {
  const Bytes out = no_bytes();
  X509_NAME_print_ex(out.get(), X509_get_subject_name(&certificate), 0, XN_FLAG_RFC2253);
  return text_of(*out);
}

bool names_somebody(std::span<const std::uint8_t> certificate) noexcept {
  if (certificate.empty() || certificate.size() > kLargestCertificate) return false;
  const Bytes bytes{BIO_new_mem_buf(certificate.data(), static_cast<int>(certificate.size()))};
  const Certificate read{PEM_read_bio_X509_AUX(bytes.get(), nullptr, nullptr, nullptr)};
  ERR_clear_error();
  return read != nullptr && X509_NAME_entry_count(X509_get_subject_name(read.get())) > 0;
}

std::string announced_name(const X509& certificate) {
  char* const text = X509_NAME_oneline(X509_get_subject_name(&certificate), nullptr, 0);
  const std::string name = text == nullptr ? "" : text;
  OPENSSL_free(text);
  return name;
}

bool belong_together(const X509& certificate, const EVP_PKEY& key) {
  const bool same = EVP_PKEY_eq(X509_get0_pubkey(&certificate), &key) == 1;
  ERR_clear_error();
  return same;
}

Certificate make_certificate(Kind kind, const Subject& subject, EVP_PKEY& key, X509* issuer,
                             EVP_PKEY& issuer_key, Validity validity) {
  Certificate certificate{X509_new()};
  X509_set_version(certificate.get(), X509_VERSION_3);
  X509_set_serialNumber(certificate.get(), new_serial().get());
  X509_set1_notBefore(certificate.get(), time_of(validity.from).get());
  X509_set1_notAfter(certificate.get(), time_of(validity.until).get());
  X509_set_pubkey(certificate.get(), &key);
  Name name{X509_NAME_new()};
  if (kind == Kind::authority) {
    add_part(*name, "O", subject.cell);
    add_part(*name, "CN", subject.name);
  } else {
    name = name_of(subject);
  }
  X509_set_subject_name(certificate.get(), name.get());
  X509& by = issuer == nullptr ? *certificate : *issuer;
  X509_set_issuer_name(certificate.get(), X509_get_subject_name(&by));
  extend(*certificate, by, NID_subject_key_identifier, "hash");
  extend(*certificate, by, NID_basic_constraints,
         kind == Kind::authority ? "critical,CA:TRUE,pathlen:0" : "critical,CA:FALSE");
  extend(*certificate, by, NID_key_usage,
         kind == Kind::authority ? "critical,digitalSignature,keyCertSign,cRLSign"
                                 : "critical,digitalSignature");
  TAKT_CHECK(X509_sign(certificate.get(), &issuer_key, EVP_sha256()) > 0);
  return certificate;
}

Result<void> check_issued(X509& certificate, X509& authority, std::int64_t now) {
  const Store store{X509_STORE_new()};
  X509_STORE_add_cert(store.get(), &authority);
  const StoreContext context{X509_STORE_CTX_new()};
  X509_STORE_CTX_init(context.get(), store.get(), &certificate, nullptr);
  X509_STORE_CTX_set_time(context.get(), 0, static_cast<std::time_t>(now));
  const bool good = X509_verify_cert(context.get()) == 1;
  const int error = X509_STORE_CTX_get_error(context.get());
  ERR_clear_error();
  if (good) return {};
  switch (error) {
    case X509_V_ERR_CERT_HAS_EXPIRED:
      return fail("it has expired", "run takt secure renew and copy the folder again");
    case X509_V_ERR_CERT_NOT_YET_VALID:
      return fail("it is not valid yet", "set the clock of this machine");
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY:
    case X509_V_ERR_CERT_SIGNATURE_FAILURE:
    case X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT:
      return fail("it was issued by another authority",
                  "copy the whole folder again from the machine of the authority");
    default:
      return fail(X509_verify_cert_error_string(error),
                  "copy the whole folder again from the machine of the authority");
  }
}

std::string serial_of(const X509& certificate) { return to_hex(*X509_get0_serialNumber(&certificate)); }

std::set<std::string> serials_in(X509_CRL& crl) {
  std::set<std::string> serials;
  const STACK_OF(X509_REVOKED)* const entries = X509_CRL_get_REVOKED(&crl);
  for (int i = 0; i < sk_X509_REVOKED_num(entries); ++i)
    serials.insert(to_hex(*X509_REVOKED_get0_serialNumber(sk_X509_REVOKED_value(entries, i))));
  return serials;
}

bool is_revoked(X509_CRL& crl, const X509& certificate) {
  X509_REVOKED* entry = nullptr;
  return X509_CRL_get0_by_serial(&crl, &entry,
                                 const_cast<ASN1_INTEGER*>(X509_get0_serialNumber(&certificate))) == 1;
}

Crl make_crl(X509_CRL* before, const X509* more, X509& authority, EVP_PKEY& key, std::int64_t now) {
  Crl crl{X509_CRL_new()};
  X509_CRL_set_version(crl.get(), X509_CRL_VERSION_2);
  X509_CRL_set_issuer_name(crl.get(), X509_get_subject_name(&authority));
  X509_CRL_set1_lastUpdate(crl.get(), time_of(now).get());
  X509_CRL_set1_nextUpdate(crl.get(), X509_get0_notAfter(&authority));
  const auto add = [&crl](const ASN1_INTEGER* serial, const ASN1_TIME* since) {
    X509_REVOKED* entry = X509_REVOKED_new();
    X509_REVOKED_set_serialNumber(entry, const_cast<ASN1_INTEGER*>(serial));
    X509_REVOKED_set_revocationDate(entry, const_cast<ASN1_TIME*>(since));
    X509_CRL_add0_revoked(crl.get(), entry);
  };
  if (STACK_OF(X509_REVOKED)* old = before == nullptr ? nullptr : X509_CRL_get_REVOKED(before)) {
    for (int i = 0; i < sk_X509_REVOKED_num(old); ++i) {
      const X509_REVOKED* entry = sk_X509_REVOKED_value(old, i);
      add(X509_REVOKED_get0_serialNumber(entry), X509_REVOKED_get0_revocationDate(entry));
    }
  }
  if (more != nullptr) add(X509_get0_serialNumber(more), time_of(now).get());
  X509_CRL_sort(crl.get());
  TAKT_CHECK(X509_CRL_sign(crl.get(), &key, EVP_sha256()) > 0);
  return crl;
}

bool is_signed_by(X509_CRL& crl, X509& authority) {
  const bool good = X509_CRL_verify(&crl, X509_get0_pubkey(&authority)) == 1;
  ERR_clear_error();
  return good;
}

std::string sign_document(const std::string& text, X509& certificate, EVP_PKEY& key) {
  constexpr int kFlags = PKCS7_TEXT | PKCS7_DETACHED | PKCS7_STREAM;
  const Bytes in = bytes_of(text);
  const Pkcs7 pkcs7{PKCS7_sign(&certificate, &key, nullptr, in.get(), kFlags)};
  const Bytes out = no_bytes();
  TAKT_CHECK(pkcs7 != nullptr && SMIME_write_PKCS7(out.get(), pkcs7.get(), in.get(), kFlags) == 1);
  return text_of(*out);
}

Result<std::string> open_document(const std::string& smime, X509& certificate) {
  BIO* content = nullptr;
  const Pkcs7 pkcs7{SMIME_read_PKCS7(bytes_of(smime).get(), &content)};
  const Bytes owned{content};
  if (pkcs7 == nullptr || content == nullptr) {
    ERR_clear_error();
    return fail("it is not a signed document",
                "copy the whole folder again from the machine of the authority");
  }
  STACK_OF(X509)* signers = sk_X509_new_null();
  sk_X509_push(signers, &certificate);
  const Bytes out = no_bytes();
  const bool good = PKCS7_verify(pkcs7.get(), signers, nullptr, content, out.get(),
                                 PKCS7_TEXT | PKCS7_NOINTERN | PKCS7_NOVERIFY) == 1;
  sk_X509_free(signers);
  ERR_clear_error();
  if (!good)
    return fail("its signature was not made by the authority",
                "copy the whole folder again from the machine of the authority");
  return text_of(*out);
}

Prefix prefix_of(const Subject& subject) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned length = 0;
  TAKT_CHECK(X509_NAME_digest(name_of(subject).get(), EVP_sha256(), digest.data(), &length) == 1);
  // Build the prefix as DDS Security 1.1, section 9.3.3, defines it: one bit with the value 1, then the first
  // 47 bits of the hash.
  Prefix prefix{};
  for (std::size_t i = 0; i < prefix.size(); ++i) {
    const unsigned above = i == 0 ? 1U : digest[i - 1];
    prefix[i] = static_cast<std::uint8_t>(((above << 7) | (digest[i] >> 1)) & 0xffU);
  }
  return prefix;
}

}  // namespace takt::security
