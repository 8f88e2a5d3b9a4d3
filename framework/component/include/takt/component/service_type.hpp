// The types on the links of a service: a request or a reply, together with the numbers of the client and of
// the request. Both are ordinary port types. A program that uses any DDS can send and receive them with this
// IDL:
//
//   @final struct NAME_Request { unsigned long long client; unsigned long long number; long long timeout_ns;
//                                NAME request; };
//   @final struct NAME_Reply { unsigned long long client; unsigned long long number; NAME reply;
//                              takt::ServiceCode code; string<127> reason; };
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include <takt/component/port_type.hpp>
#include <takt/core/cdr.hpp>

namespace takt {

/// The maximum length of a reason, in bytes.
inline constexpr std::size_t kReasonLength = 127;

/// The outcome of a request.
enum class ServiceCode : std::uint32_t {
  replied,  ///< `reply` is the reply
  refused   ///< the request was rejected; `reason` states why
};

/// A request. Each client chooses its own `client` number, and numbers its requests in `number`. The reply
/// contains both numbers of its request.
template <class T>
struct ServiceRequest {
  std::uint64_t client = 0;
  std::uint64_t number = 0;
  std::int64_t timeout_ns =
      0;  ///< time-out, counted from the sample's stamp; after it, the service does not serve the request
  T request{};
};

/// The answer to a request.
template <class T>
struct ServiceReply {
  std::uint64_t client = 0;
  std::uint64_t number = 0;
  T reply{};
  ServiceCode code = ServiceCode::replied;
  std::array<char, kReasonLength + 1> reason{};  ///< why the request was rejected
};

namespace detail {

/// Text that joined() builds at compile time.
template <std::size_t Size>
struct StaticText {
  std::array<char, Size + 1> characters{};
};

template <std::size_t Size, class... Parts>
constexpr StaticText<Size> joined(Parts... parts) {
  StaticText<Size> text;
  char* to = text.characters.data();
  ((to = std::copy(parts.begin(), parts.end(), to)), ...);
  return text;
}

/// Returns the part of `{"name":"X","fields":[...]}` after `"fields":`, without the last brace.
constexpr std::string_view fields_of(std::string_view description) {
  constexpr std::string_view kFields = R"("fields":)";
  const std::size_t at = description.find(kFields) + kFields.size();
  return description.substr(at, description.size() - at - 1);
}

/// The name and description of the struct ServiceRequest<T> or ServiceReply<T>, made from the name and
/// description of T.
template <class T, class Around>
struct WrappedType {
  static constexpr std::string_view kInner = PortType<T>::info.name;
  static constexpr std::string_view kFields = fields_of(PortType<T>::info.description);
  static constexpr auto name = joined<kInner.size() + Around::kSuffix.size()>(kInner, Around::kSuffix);
  static constexpr std::string_view kName{name.characters.data()};
  static constexpr std::string_view kOpen = R"({"name":")";
  static constexpr std::string_view kOf = R"(,"type":"struct","of":")";
  static constexpr std::string_view kIts = R"(","fields":)";
  static constexpr auto description =
      joined<kOpen.size() + kName.size() + Around::kBefore.size() + kOf.size() + kInner.size() + kIts.size() +
             kFields.size() + Around::kAfter.size()>(kOpen, kName, Around::kBefore, kOf, kInner, kIts,
                                                     kFields, Around::kAfter);
};

struct AroundRequest {
  static constexpr std::string_view kSuffix = "_Request";
  static constexpr std::string_view kBefore =
      R"(","fields":[{"name":"client","type":"unsigned long long"},)"
      R"({"name":"number","type":"unsigned long long"},{"name":"timeout_ns","type":"long long"},)"
      R"({"name":"request")";
  static constexpr std::string_view kAfter = "}]}";
};

struct AroundReply {
  static constexpr std::string_view kSuffix = "_Reply";
  static constexpr std::string_view kBefore =
      R"(","fields":[{"name":"client","type":"unsigned long long"},)"
      R"({"name":"number","type":"unsigned long long"},{"name":"reply")";
  static constexpr std::string_view kAfter =
      R"(},{"name":"code","type":"enum","of":"takt::ServiceCode",)"
      R"("enumerators":["SERVICE_REPLIED","SERVICE_REFUSED"]},{"name":"reason","type":"string","bound":127}]})";
};

}  // namespace detail

template <class T>
struct PortType<ServiceRequest<T>> {
  using Wrapped = detail::WrappedType<T, detail::AroundRequest>;
  // The members before the inner sample have a size that is a multiple of 8, so they do not change the inner
  // sample's alignment.
  static constexpr TypeInfo info{Wrapped::name.characters.data(), Wrapped::description.characters.data(),
                                 3 * 8 + PortType<T>::info.max_size};

  static std::uint32_t encode(const ServiceRequest<T>& value, std::byte* to, std::uint32_t size) noexcept {
    CdrWriter writer{to, size};
    writer.put(value.client);
    writer.put(value.number);
    writer.put(value.timeout_ns);
    PortType<T>::put(writer, value.request);
    return writer.size();
  }
  static bool fits(const ServiceRequest<T>& value) noexcept { return PortType<T>::fits(value.request); }
  static bool decode(const std::byte* from, std::uint32_t size, ServiceRequest<T>& value) noexcept {
    CdrReader reader{from, size};
    value.client = reader.get<std::uint64_t>();
    value.number = reader.get<std::uint64_t>();
    value.timeout_ns = reader.get<std::int64_t>();
    try {
      PortType<T>::get(reader, value.request);
    } catch (...) {
      return false;
    }
    return reader.complete();
  }
  static void reserve(ServiceRequest<T>& value) { PortType<T>::reserve(value.request); }
};

template <class T>
struct PortType<ServiceReply<T>> {
  using Wrapped = detail::WrappedType<T, detail::AroundReply>;
  static constexpr TypeInfo info{
      Wrapped::name.characters.data(), Wrapped::description.characters.data(),
      2 * 8 + PortType<T>::info.max_size + 4 + 4 + static_cast<std::uint32_t>(kReasonLength + 1)};

  static std::uint32_t encode(const ServiceReply<T>& value, std::byte* to, std::uint32_t size) noexcept {
    CdrWriter writer{to, size};
    writer.put(value.client);
    writer.put(value.number);
    PortType<T>::put(writer, value.reply);
    writer.put_enumerator(static_cast<std::uint32_t>(value.code), kCodes);
    writer.put_text(value.reason.data(), kReasonLength, kReasonLength);
    return writer.size();
  }
  static bool fits(const ServiceReply<T>& value) noexcept { return PortType<T>::fits(value.reply); }
  static bool decode(const std::byte* from, std::uint32_t size, ServiceReply<T>& value) noexcept {
    CdrReader reader{from, size};
    value.client = reader.get<std::uint64_t>();
    value.number = reader.get<std::uint64_t>();
    try {
      PortType<T>::get(reader, value.reply);
    } catch (...) {
      return false;
    }
    value.code = static_cast<ServiceCode>(reader.get_enumerator(kCodes));
    reader.get_text(value.reason.data(), kReasonLength);
    return reader.complete();
  }
  static void reserve(ServiceReply<T>& value) { PortType<T>::reserve(value.reply); }

 private:
  static constexpr std::uint32_t kCodes = 2;
};

}  // namespace takt
