// OpenSSL's objects, each freed by its owner. Not for other rooms.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/x509.h>

#include <takt/core/result.hpp>
#include <takt/security/access.hpp>

namespace takt::security {

template <auto function>
struct FreedBy {
  template <class T>
  void operator()(T* object) const noexcept {
    function(object);
  }
};
using Key = std::unique_ptr<EVP_PKEY, FreedBy<EVP_PKEY_free>>;
using Certificate = std::unique_ptr<X509, FreedBy<X509_free>>;
using Crl = std::unique_ptr<X509_CRL, FreedBy<X509_CRL_free>>;
using Bytes = std::unique_ptr<BIO, FreedBy<BIO_free_all>>;

/// Of what OpenSSL refused last, in its words.
std::string openssl_reason();

/// Of the curve P-256.
Key make_key();

/// PEM. Empty where it is none.
Key key_from(std::string_view pem);
Certificate certificate_from(std::string_view pem);
Crl crl_from(std::string_view pem);
std::string to_pem(EVP_PKEY& key);
std::string to_pem(X509& certificate);
std::string to_pem(X509_CRL& crl);

/// Seconds since 1970.
std::int64_t valid_until(const X509& certificate);

/// "CN=robot,OU=device,O=cell": as permissions must name it.
std::string subject_text(const X509& certificate);
/// "/O=cell/CN=identities 3f2a": as a participant announces who issued its identity.
std::string announced_name(const X509& certificate);
bool belong_together(const X509& certificate, const EVP_PKEY& key);

enum class Kind { authority, identity };
/// A certificate for `key`, signed by `issuer` with its key; by itself for an authority, where `issuer` is
/// null. The name is `subject`; of an authority its cell and name alone.
Certificate make_certificate(Kind kind, const Subject& subject, EVP_PKEY& key, X509* issuer,
                             EVP_PKEY& issuer_key, Validity validity);

/// Fails with the reason where the authority did not issue the certificate, or it is not valid at this time.
Result<void> check_issued(X509& certificate, X509& authority, std::int64_t now);

/// Whether it is on the list.
bool is_revoked(X509_CRL& crl, const X509& certificate);
/// A list of what was on `before`, if there was one, and of `more`, if given; valid as long as the authority.
Crl make_crl(X509_CRL* before, const X509* more, X509& authority, EVP_PKEY& key, std::int64_t now);
bool is_signed_by(X509_CRL& crl, X509& authority);

/// A document as S/MIME, signed in the clear.
std::string sign_document(const std::string& text, X509& certificate, EVP_PKEY& key);
/// The document's text. Fails where it is none, or not signed with exactly this certificate's key.
Result<std::string> open_document(const std::string& smime, X509& certificate);

Bytes bytes_of(std::string_view text);
Bytes no_bytes();
std::string text_of(BIO& bytes);

}  // namespace takt::security
