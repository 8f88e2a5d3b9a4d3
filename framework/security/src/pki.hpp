// Smart pointers for OpenSSL objects, and functions that use these objects. Only the source files of
// framework/security include this header.
#pragma once

#include <cstdint>
#include <memory>
#include <set>
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

/// Returns OpenSSL's own text for its last error.
std::string openssl_reason();

/// Creates a key on the curve P-256.
Key make_key();

/// These functions read a key, a certificate or a list of revoked certificates from PEM text. They return
/// null if the text is not valid.
Key key_from(std::string_view pem);
Certificate certificate_from(std::string_view pem);
Crl crl_from(std::string_view pem);
std::string to_pem(EVP_PKEY& key);
std::string to_pem(X509& certificate);
std::string to_pem(X509_CRL& crl);

/// Returns the end of the certificate's validity, in seconds since 1970.
std::int64_t valid_until(const X509& certificate);

/// Returns the subject in the form that permissions require: "CN=robot,OU=device,O=cell".
std::string subject_text(const X509& certificate);
/// Returns the name of an authority in the form that participants announce: "/O=cell/CN=identities 3f2a".
std::string announced_name(const X509& certificate);
/// Returns true if the certificate was issued for this key.
bool belong_together(const X509& certificate, const EVP_PKEY& key);

enum class Kind { authority, identity };
/// Creates a certificate for `key` and `subject`, signed by `issuer` with `issuer_key`. For an authority,
/// `issuer` must be null and `issuer_key` must be `key`: the authority signs its own certificate. The
/// certificate of an authority contains only the cell and the name of `subject`, not the role.
Certificate make_certificate(Kind kind, const Subject& subject, EVP_PKEY& key, X509* issuer,
                             EVP_PKEY& issuer_key, Validity validity);

/// Fails with the reason if the authority did not issue the certificate, or if the certificate is not valid
/// at the time `now`.
Result<void> check_issued(X509& certificate, X509& authority, std::int64_t now);

/// Returns the serial number of the certificate, in hexadecimal digits.
std::string serial_of(const X509& certificate);
/// Returns the serial numbers of all certificates on the list.
std::set<std::string> serials_in(X509_CRL& crl);
/// Returns true if the certificate is on the list of revoked certificates.
bool is_revoked(X509_CRL& crl, const X509& certificate);
/// Creates a list of revoked certificates from the entries of the list `before` and the certificate `more`,
/// both of which may be null. The list is valid as long as the authority's certificate.
Crl make_crl(X509_CRL* before, const X509* more, X509& authority, EVP_PKEY& key, std::int64_t now);
bool is_signed_by(X509_CRL& crl, X509& authority);

/// Signs a document. The result is in S/MIME format and contains the text unencrypted.
std::string sign_document(const std::string& text, X509& certificate, EVP_PKEY& key);
/// Returns the text of a signed document. Fails if `smime` is not a signed document, or if it was not signed
/// with the key of this certificate.
Result<std::string> open_document(const std::string& smime, X509& certificate);

Bytes bytes_of(std::string_view text);
Bytes no_bytes();
std::string text_of(BIO& bytes);

}  // namespace takt::security
