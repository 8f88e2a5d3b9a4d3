// takt::Service and takt::Client: request and reply between components, on one device or across devices. Each
// client gets the reply to its own request. A service and a client each have two ports, NAME/request and
// NAME/reply; the descriptor connects them with <service client="..." server="..."/>.
//
// A service with a handler. The handler runs on its own thread, and returns a reply or takt::fail("why not"):
//
//   takt::Service<line::Reset, line::Throughput> reset{
//       *this, "reset", [this](const line::Reset& request) { return do_it(request); }};
//
// A service without a handler. run() replies, in the same cycle or some cycles later:
//
//   takt::Service<line::Reset, line::Throughput> reset{*this, "reset"};
//   ...
//   if (reset.take()) reset.reply(do_it(reset.request()));
//
// A client. run() sends a request with call() and asks for the reply with poll(), in this cycle or a later
// one. Both functions return at once:
//
//   takt::Client<line::Reset, line::Throughput> reset{*this, "reset"};
//   ...
//   reset.call(request, 200ms);
//   if (reset.poll() == takt::CallStatus::replied) use(reset.reply());
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

#include <takt/component/in_port.hpp>
#include <takt/component/out_port.hpp>
#include <takt/component/owner.hpp>
#include <takt/component/service_type.hpp>
#include <takt/core/result.hpp>

namespace takt {

namespace detail {

/// Returns the failure that this thread reported with fail() or takt_fail(), and clears it. Returns null if
/// there is none.
const char* take_reported_failure() noexcept;

template <class T>
class RequestIn final : public InPort<ServiceRequest<T>> {
 public:
  RequestIn(Component* owner, const std::string& name, PortRole role, PortOptions options)
      // run() does not read the requests that a handler answers, so these requests must not wake a sporadic
      // module.
      : InPort<ServiceRequest<T>>(owner, name + kRequestPort,
                                  role == PortRole::handler ? PortDirection::in : PortDirection::event,
                                  std::move(options)) {
    this->set_role(role);
  }
  using InPort<ServiceRequest<T>>::taken_from;
  /// True if the client no longer waits for the reply to the last request that was read.
  [[nodiscard]] bool is_expired() const noexcept {
    return this->age() > Nanoseconds{this->value().timeout_ns};
  }
  void count_expired() noexcept { this->count_late(); }
};

template <class T>
class ReplyOut final : public OutPort<ServiceReply<T>> {
 public:
  ReplyOut(Component* owner, const std::string& name, PortRole role, PortOptions options)
      : OutPort<ServiceReply<T>>(owner, name + kReplyPort, {.text = std::move(options.text)}) {
    this->set_role(role);
  }
  using OutPort<ServiceReply<T>>::write_to;
};

template <class T>
class RequestOut final : public OutPort<ServiceRequest<T>> {
 public:
  RequestOut(Component* owner, const std::string& name, PortOptions options)
      : OutPort<ServiceRequest<T>>(owner, name + kRequestPort, {.text = std::move(options.text)}) {
    this->set_role(PortRole::client);
  }
  /// Returns the start of the current run(), in ns of the monotonic clock.
  [[nodiscard]] std::int64_t now_ns() const noexcept { return this->context().start_ns; }
};

template <class T>
class ReplyIn final : public InPort<ServiceReply<T>> {
 public:
  ReplyIn(Component* owner, const std::string& name, PortOptions options)
      : InPort<ServiceReply<T>>(owner, name + kReplyPort, PortDirection::event, std::move(options)) {
    this->set_role(PortRole::client);
  }
  void count_late_reply() noexcept { this->count_late(); }
};

}  // namespace detail

/// The part of a service that does not depend on the types of request and reply. The host uses it.
class ServiceBase {
 public:
  ServiceBase(const ServiceBase&) = delete;
  ServiceBase& operator=(const ServiceBase&) = delete;
  virtual ~ServiceBase() = default;

  /// True if an unread request has arrived. Only the thread that calls handle() may call it.
  [[nodiscard]] virtual bool has_request() const noexcept = 0;
  /// Takes one request and answers it with the handler. If `refusal` is not null, rejects the request with
  /// this reason instead. Returns false if there was no request. Not for real-time threads. Only one thread
  /// at a time may call handle(), which may run at the same time as the module's run().
  virtual bool handle(const char* refusal) = 0;

 protected:
  ServiceBase() = default;
  /// Registers the service with its component, so that Takt calls handle().
  void enlist(Component& owner);
};

/// Answers requests. Request and Reply are structs of IDL files (see takt_add_idl()).
///
/// With a handler: the handler runs on a thread of the module that is not real-time, while the module is
/// EXECUTING. The handler may run at the same time as run() and condition(), but never at the same time as
/// another hook. It may share only atomic variables with run(), and must not use properties or ports. It may
/// allocate and wait, but after 5 s it counts as hung, as a hook does. If it throws, or fails with fail(),
/// the client's call is rejected with that reason. While the module is not EXECUTING, requests are rejected.
///
/// Without a handler: run() takes requests and replies on the real-time thread. run() may call every function
/// of Service except the constructor; these functions neither wait nor allocate. While the module is not
/// EXECUTING, requests are not taken, and the calls of the clients time out.
///
/// In both cases, a request that is taken after its client's time-out is rejected and never served.
template <class Request, class Reply>
class Service final : public ServiceBase {
 public:
  /// The options of the service.
  using Options = PortOptions;
  /// A function that answers a request: it returns the reply, or takt::fail("why not").
  using Handler = std::function<Result<Reply>(const Request&)>;

  /// Constructs a service of a component, as a member, with a handler. The constructor is a template, so that
  /// the compiler does not take options in braces for a handler. Allocates memory, so not for real-time
  /// threads.
  template <std::convertible_to<Handler> Callable>
  Service(detail::Owner owner, const std::string& name, Callable handler, const Options& options = {})
      : Service(owner.component(), name, PortRole::handler, options) {
    handler_ = std::move(handler);
    enlist(*owner.component());
  }
  /// Constructs a service of a component, as a member, without a handler. Allocates memory, so not for
  /// real-time threads.
  Service(detail::Owner owner, const std::string& name, const Options& options = {})
      : Service(owner.component(), name, PortRole::service, options) {}
  /// Constructs a service in a process module. The service must be a global variable, or must be constructed
  /// before initPeriodExe() or initSporadicExe() is called. Allocates memory.
  explicit Service(const std::string& name, const Options& options = {})
      : Service(nullptr, name, PortRole::service, options) {
    static_assert(detail::InProgram<Request>,
                  "pass *this as the first argument: takt::Service<Request, Reply> service{*this, "
                  "\"service\"}; only a program, which includes <takt/process.hpp>, omits it");
  }

  /// Takes the next request, which request() then returns. Returns false if no request has arrived. Drops a
  /// request that was taken before and not answered. Rejects requests whose time-out has passed. A real-time
  /// thread may call it.
  bool take() noexcept {
    busy_ = false;
    while (in_.read()) {
      from_ = in_.taken_from();
      const ServiceRequest<Request>& request = in_.value();
      answer_.client = request.client;
      answer_.number = request.number;
      busy_ = true;
      if (!in_.is_expired()) return true;
      in_.count_expired();
      refuse("the request arrived after its time-out; check that the clocks of both devices are in sync");
    }
    return false;
  }
  /// True if a request was taken and not yet answered. A real-time thread may call it.
  [[nodiscard]] bool busy() const noexcept { return busy_; }
  /// The request that was taken last; Request{} before the first request. Valid until the next take(). A
  /// real-time thread may call it.
  [[nodiscard]] const Request& request() const noexcept { return in_.value().request; }
  /// Answers the request that was taken. Does nothing if it was answered already. If the reply does not fit
  /// its type (a string or sequence exceeds its bound, or an enumerator is invalid), the request is rejected
  /// with that reason. A real-time thread may call it.
  void reply(const Reply& reply) noexcept {
    if (!busy_) return;
    if (!PortType<Reply>::fits(reply))
      return refuse(
          "the reply does not fit its type: a string or sequence exceeds its bound, or an enumerator is "
          "invalid");
    answer_.reply = reply;
    answer(ServiceCode::replied, {});
  }
  /// Rejects the request that was taken, with a reason of at most 127 bytes. Longer text is cut off. Does
  /// nothing if the request was answered already. A real-time thread may call it.
  void refuse(const char* reason) noexcept {
    if (!busy_) return;
    answer(ServiceCode::refused, reason);
  }

  [[nodiscard]] bool has_request() const noexcept override { return in_.has_news(); }
  bool handle(const char* refusal) override {
    if (!take()) return false;
    if (refusal != nullptr) {
      refuse(refusal);
      return true;
    }
    static_cast<void>(detail::take_reported_failure());
    try {
      const Result<Reply> result = handler_(request());
      if (const char* failure = detail::take_reported_failure(); failure != nullptr)
        refuse(failure);
      else if (result)
        reply(*result);
      else
        refuse(in_words(result.problems()).c_str());
    } catch (const std::exception& exception) {
      refuse((std::string{"the handler threw: "} + exception.what()).c_str());
    } catch (...) {
      refuse("the handler threw something that is not a std::exception");
    }
    return true;
  }

 private:
  Service(Component* owner, const std::string& name, PortRole role, const Options& options)
      : in_(owner, name, role, options), out_(owner, name, role, {}) {
    PortType<ServiceReply<Reply>>::reserve(answer_);
  }
  void answer(ServiceCode code, std::string_view reason) noexcept {
    busy_ = false;
    answer_.code = code;
    const std::size_t length = std::min(reason.size(), kReasonLength);
    // This code does not use memcpy(), because reason.data() may be null.
    std::copy_n(reason.begin(), length, answer_.reason.begin());
    answer_.reason[length] = '\0';
    // The connection for the client's replies has the same index as the connection of the request, because
    // both connections are made in the same order.
    out_.write_to(from_, answer_);
  }

  detail::RequestIn<Request> in_;
  detail::ReplyOut<Reply> out_;
  Handler handler_;
  ServiceReply<Reply> answer_;
  std::size_t from_ = 0;
  bool busy_ = false;
};

/// The state of a client's call.
enum class CallStatus {
  idle,       ///< call() was not called yet
  pending,    ///< no answer yet
  replied,    ///< reply() is the answer
  refused,    ///< the service rejected the request; reason() is the reason
  timed_out,  ///< no answer within the time-out; the service may or may not have acted
  nobody,     ///< no service: no `<service>` names the client, or the other device is lost
};
/// Returns the name of the status: "idle", "pending", ...
const char* to_text(CallStatus status) noexcept;

/// Calls a service. Request and Reply are structs of IDL files (see takt_add_idl()).
///
/// Every hook, in particular run(), may call every function except the constructor; these functions neither
/// wait nor allocate. Only one thread at a time may use a client. A client has one call at a time, and a new
/// call abandons the previous one. The time-out is measured from the start of the run() that calls call() to
/// the start of the run() that calls poll(). In a sporadic module an answer is an event: it makes the module
/// ready to run, and run() must poll(). A time-out is not an event.
template <class Request, class Reply>
class Client {
 public:
  /// The options of the client.
  using Options = PortOptions;

  /// Constructs a client of a component, as a member. Allocates memory, so not for real-time threads.
  Client(detail::Owner owner, const std::string& name, const Options& options = {})
      : Client(owner.component(), name, options) {}
  /// Constructs a client in a process module. The client must be a global variable, or must be constructed
  /// before initPeriodExe() or initSporadicExe() is called. Allocates memory.
  explicit Client(const std::string& name, const Options& options = {}) : Client(nullptr, name, options) {
    static_assert(detail::InProgram<Request>,
                  "pass *this as the first argument: takt::Client<Request, Reply> client{*this, "
                  "\"client\"}; only a program, which includes <takt/process.hpp>, omits it");
  }

  /// Sends a request once, and abandons the previous call. `timeout`: the time for which poll() accepts the
  /// answer after this call. Returns `pending`, or `nobody` if there is no service, or `refused` if the
  /// request does not fit its type (a string or sequence exceeds its bound, or an enumerator is invalid). A
  /// real-time thread may call it.
  CallStatus call(const Request& request, Nanoseconds timeout) noexcept {
    const std::int64_t now = out_.now_ns();
    // A restarted module numbers its requests from 1 again. Its new client number distinguishes the replies
    // to its requests from the replies to the former instance.
    if (question_.client == 0) question_.client = static_cast<std::uint64_t>(now);
    ++question_.number;
    reason_ = "";
    if (!PortType<Request>::fits(request)) {
      reason_ =
          "the request does not fit its type: a string or sequence exceeds its bound, or an enumerator is "
          "invalid";
      return status_ = CallStatus::refused;
    }
    if (!out_.connected()) return status_ = CallStatus::nobody;
    question_.request = request;
    question_.timeout_ns = timeout.count();
    out_.write(question_);
    until_ns_ = now + timeout.count();
    return status_ = CallStatus::pending;
  }

  /// Reads the answer if it has arrived, and returns the status of the call. A status other than `pending`
  /// stays until the next call(). A real-time thread may call it.
  CallStatus poll() noexcept {
    while (in_.read()) {
      const ServiceReply<Reply>& answer = in_.value();
      if (answer.client != question_.client) continue;  // a reply to a former instance of this module
      if (status_ != CallStatus::pending || answer.number != question_.number) {
        ++late_;
        in_.count_late_reply();
        continue;
      }
      if (answer.code == ServiceCode::replied) {
        reply_ = answer.reply;
        status_ = CallStatus::replied;
      } else {
        refusal_ = answer.reason;
        reason_ = refusal_.data();
        status_ = CallStatus::refused;
      }
    }
    if (status_ == CallStatus::pending && out_.now_ns() >= until_ns_) status_ = CallStatus::timed_out;
    return status_;
  }
  /// The status that the last call() or poll() returned. A real-time thread may call it.
  [[nodiscard]] CallStatus status() const noexcept { return status_; }
  /// The last reply that arrived; Reply{} before the first reply. A real-time thread may call it.
  [[nodiscard]] const Reply& reply() const noexcept { return reply_; }
  /// Why the call was rejected; empty in other cases. A real-time thread may call it.
  [[nodiscard]] const char* reason() const noexcept { return reason_; }
  /// Number of answers that arrived too late and were dropped. A real-time thread may call it.
  [[nodiscard]] std::uint64_t late() const noexcept { return late_; }
  /// True if a service is connected. A real-time thread may call it.
  [[nodiscard]] bool connected() const noexcept { return out_.connected(); }

 private:
  Client(Component* owner, const std::string& name, const Options& options)
      : out_(owner, name, options), in_(owner, name, {}) {
    PortType<ServiceRequest<Request>>::reserve(question_);
    PortType<Reply>::reserve(reply_);
  }

  detail::RequestOut<Request> out_;
  detail::ReplyIn<Reply> in_;
  ServiceRequest<Request> question_;
  CallStatus status_ = CallStatus::idle;
  std::int64_t until_ns_ = 0;
  std::uint64_t late_ = 0;
  Reply reply_{};
  std::array<char, kReasonLength + 1> refusal_{};
  const char* reason_ = "";
};

}  // namespace takt
