// OpenSSL objects with owners that free them, and functions that use these objects. Other rooms must not
// include this header.
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

/// The reason of the last OpenSSL error, as OpenSSL words it.
std::string openssl_reason();

/// A new key on the curve P-256.
Key make_key();

/// Read a key, a certificate or a list from PEM text. They return null if the text is not valid.
Key key_from(std::string_view pem);
Certificate certificate_from(std::string_view pem);
Crl crl_from(std::string_view pem);
std::string to_pem(EVP_PKEY& key);
std::string to_pem(X509& certificate);
std::string to_pem(X509_CRL& crl);

/// The end of the certificate's validity, in seconds since 1970.
std::int64_t valid_until(const X509& certificate);

/// The subject as permissions must write it: "CN=robot,OU=device,O=cell".
std::string subject_text(const X509& certificate);
/// The name of an authority as participants announce it: "/O=cell/CN=identities 3f2a".
std::string announced_name(const X509& certificate);
/// Whether the certificate is for this key.
bool belong_together(const X509& certificate, const EVP_PKEY& key);

enum class Kind { authority, identity };
/// A certificate for `key`, signed by `issuer` with its key. For an authority, `issuer` is null and the
/// certificate signs itself. The certificate names `subject`; that of an authority names only the cell and
/// the name.
Certificate make_certificate(Kind kind, const Subject& subject, EVP_PKEY& key, X509* issuer,
                             EVP_PKEY& issuer_key, Validity validity);

/// Fails with the reason if the authority did not issue the certificate, or if it is not valid at this time.
Result<void> check_issued(X509& certificate, X509& authority, std::int64_t now);

/// Whether the certificate is on the list.
bool is_revoked(X509_CRL& crl, const X509& certificate);
/// A list with the entries of `before` and the certificate `more`; both may be null. The list is valid as
/// long as the authority.
Crl make_crl(X509_CRL* before, const X509* more, X509& authority, EVP_PKEY& key, std::int64_t now);
bool is_signed_by(X509_CRL& crl, X509& authority);

/// A signed document as S/MIME, with the text readable.
std::string sign_document(const std::string& text, X509& certificate, EVP_PKEY& key);
/// The text of a signed document. Fails if `smime` is not a signed document, or was not signed with the key
/// of this certificate.
Result<std::string> open_document(const std::string& smime, X509& certificate);

Bytes bytes_of(std::string_view text);
Bytes no_bytes();
std::string text_of(BIO& bytes);

}  // namespace takt::security
