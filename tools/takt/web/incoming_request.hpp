// Reads one HTTP request from an untrusted client, within limits.
//
// The HTTP library, cpp-httplib 0.11, reads whatever a client sends: a line without end, any number of header
// lines, a body in chunks, or a compressed body that becomes huge. So this class reads and checks the
// complete request before the library sees it. It passes on only the headers that `takt web` uses.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

#include "web/answer.hpp"

namespace takt::tool::web {

class IncomingRequest {
 public:
  static constexpr std::size_t kMostLine = std::size_t{4} << 10;   ///< limit of the request line
  static constexpr std::size_t kMostHead = std::size_t{16} << 10;  ///< limit of all lines before the body
  static constexpr std::size_t kMostBody = std::size_t{64} << 10;

  static constexpr std::chrono::seconds kLimit{10};  ///< a request must be complete within this time

  enum class State { incomplete, complete, rejected };

  /// Takes the next bytes from the client. Call it only while the request is incomplete. Keeps at most
  /// kMostHead + kMostBody bytes, and ignores bytes after the end of the request.
  State take(std::string_view bytes);
  /// Rejects an incomplete request whose time has passed.
  void expire();

  [[nodiscard]] bool has_begun() const noexcept { return !arrived_.empty(); }
  /// The complete request, in the form in which the HTTP library may read it.
  [[nodiscard]] const std::string& text() const noexcept { return text_; }
  /// Why the request was rejected.
  [[nodiscard]] const Answer& rejection() const noexcept { return rejection_; }

 private:
  State read_head(std::string_view head);
  State reject(int status, const std::string& what, const std::string& fix);

  std::string arrived_;
  std::size_t body_at_ = 0;  // where the body begins in arrived_; 0 while the head is incomplete
  std::size_t body_size_ = 0;
  std::string text_;
  Answer rejection_;
};

}  // namespace takt::tool::web
