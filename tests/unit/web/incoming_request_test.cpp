#include "web/incoming_request.hpp"

#include <gmock/gmock.h>

namespace takt::tool::web::incoming_request_test {
namespace {

using State = IncomingRequest::State;
using testing::HasSubstr;

constexpr std::size_t kMostKept = IncomingRequest::kMostHead + IncomingRequest::kMostBody;

/// The status with which takt web rejects a request; 0 if the request is incomplete, 200 if it is complete.
int status_of(std::string_view text) {
  IncomingRequest request;
  switch (request.take(text)) {
    case State::incomplete:
      return 0;
    case State::complete:
      return 200;
    case State::rejected:
      EXPECT_THAT(request.rejection().body, HasSubstr(R"("fix":")"));
      return request.rejection().status;
  }
  return -1;
}

/// Sends `start` and then `repeated` until takt web rejects the request. Returns the status, and checks that
/// takt web has read only a small part of what an attacker could send.
int status_of_flood(std::string_view start, std::string_view repeated) {
  IncomingRequest request;
  std::size_t sent = start.size();
  State state = request.take(start);
  while (state == State::incomplete && sent <= kMostKept) {
    state = request.take(repeated);
    sent += repeated.size();
  }
  EXPECT_EQ(state, State::rejected) << "after " << sent << " bytes";
  return request.rejection().status;
}

TEST(IncomingRequest, KeepsOnlyTheHeadersThatTheServerUses) {
  IncomingRequest request;
  EXPECT_EQ(request.take("GET /a?b=c HTTP/1.1\r\nHost: pc7\r\nRange: bytes=0-,0-\r\nCookie: c\r\n"
                         "ACCEPT-Encoding: gzip\r\nAuthorization: Bearer t\r\nExpect: 100-continue\r\n\r\n"),
            State::complete);
  EXPECT_EQ(request.text(),
            "GET /a?b=c HTTP/1.1\r\nHost: pc7\r\nACCEPT-Encoding: gzip\r\nAuthorization: Bearer t\r\n"
            "Content-Length: 0\r\n\r\n");
}

TEST(IncomingRequest, IsCompleteWithTheLastByteOfItsBody) {
  const std::string_view text = "POST /a HTTP/1.1\r\nHost: pc7\r\ncontent-length:\t4 \r\n\r\n{\r\n}";
  IncomingRequest request;
  EXPECT_FALSE(request.has_begun());
  for (const char& byte : text.substr(0, text.size() - 1)) {
    EXPECT_EQ(request.take({&byte, 1}), State::incomplete);
    EXPECT_TRUE(request.has_begun());
  }
  EXPECT_EQ(request.take(text.substr(text.size() - 1)), State::complete);
  EXPECT_EQ(request.text(), "POST /a HTTP/1.1\r\nHost: pc7\r\nContent-Length: 4\r\n\r\n{\r\n}");
}

TEST(IncomingRequest, IgnoresBytesAfterItsEnd) {
  IncomingRequest request;
  EXPECT_EQ(request.take("PUT /a HTTP/1.1\r\nContent-Length: 1\r\n\r\nxGET /b HTTP/1.1\r\n\r\n"),
            State::complete);
  EXPECT_EQ(request.text(), "PUT /a HTTP/1.1\r\nContent-Length: 1\r\n\r\nx");
}

TEST(IncomingRequest, AcceptsTheLargestHeadAndBody) {
  const std::string body(IncomingRequest::kMostBody, 'x');
  std::string head = "POST /a HTTP/1.1\r\nContent-Length: " + std::to_string(body.size()) + "\r\nCookie: ";
  head += std::string(IncomingRequest::kMostHead - head.size() - 4, 'c') + "\r\n\r\n";
  EXPECT_EQ(status_of(head + body), 200);
  IncomingRequest in_parts;
  EXPECT_EQ(in_parts.take(head), State::incomplete);
  EXPECT_EQ(in_parts.take(body), State::complete);
  head.insert(head.size() - 4, "c");
  EXPECT_EQ(status_of(head + body), 431);
}

TEST(IncomingRequest, IsRejectedBeforeAFloodFillsTheMemory) {
  EXPECT_EQ(status_of_flood("", "GET /"), 414);
  EXPECT_EQ(status_of_flood("GET / HTTP/1.1\r\n", "a: b\r\n"), 431) << "any number of header lines";
  EXPECT_EQ(status_of_flood("GET / HTTP/1.1\r\na: ", "aaaaaaaa"), 431) << "a header line without end";
  EXPECT_EQ(status_of_flood("GET / HTTP/1.1\r\n", std::string(3, '\0')), 431);
  for (const char* unlimited :
       {"Transfer-Encoding: chunked\r\n\r\n", "transfer-encoding : chunked\r\n\r\n",
        "Content-Length: 65537\r\n\r\n", "Content-Length: 99999999999999999999\r\n\r\n", "\r\n"})
    EXPECT_THAT(status_of_flood(std::string{"POST /api/command HTTP/1.1\r\n"} + unlimited, "ffffffff"),
                testing::AnyOf(400, 411, 413))
        << unlimited;
}

TEST(IncomingRequest, IsRejectedWithTheReason) {
  EXPECT_EQ(status_of("POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n"), 411);
  EXPECT_EQ(status_of("POST / HTTP/1.1\r\n\r\n"), 411) << "a body that only the end of the connection ends";
  EXPECT_EQ(status_of("POST / HTTP/1.1\r\nContent-Length: 65537\r\n\r\n"), 413);
  EXPECT_EQ(status_of("POST / HTTP/1.1\r\nContent-Length: 99999999999999999999\r\n\r\n"), 413);
  EXPECT_EQ(status_of("POST / HTTP/1.1\r\nContent-Length: 1\r\nContent-Encoding: br\r\n\r\n"), 415);
  for (const char* wrong :
       {"Content-Length: 1\r\nContent-Length: 1", "Content-Length: -1", "Content-Length: 1x",
        "Content-Length:", "no header", ": no name", "a b: c", " folded: line"})
    EXPECT_EQ(status_of(std::string{"POST / HTTP/1.1\r\n"} + wrong + "\r\n\r\n"), 400) << wrong;
  EXPECT_EQ(status_of(std::string_view{"GET /\0 HTTP/1.1\r\n\r\n", 19}), 400);
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\na: b\nTransfer-Encoding: chunked\r\n\r\n"), 400)
      << "the library also ends a line at a line feed";
  IncomingRequest slow;
  slow.take("GET");
  slow.expire();
  EXPECT_EQ(slow.rejection().status, 408);
}

}  // namespace
}  // namespace takt::tool::web::incoming_request_test
