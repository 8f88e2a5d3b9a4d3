// Request and reply: one component asks another, on this device or elsewhere, and each is given its own
// answer. Both are made of two ports, NAME/request and NAME/reply, which the descriptor connects with
// <service client="..." server="..."/>.
//
//   takt::Service<line::Reset, line::Throughput> reset{*this, "reset", [this](const line::Reset& request) {
//     return do_it(request);                    // a reply, or takt::fail("why not"); on a thread of its own
//   }};
//
//   takt::Service<line::Reset, line::Throughput> reset{*this, "reset"};
//     if (reset.take()) reset.reply(do_it(reset.request()));           // in run(), at once or some cycles
//     later
//
//   takt::Client<line::Reset, line::Throughput> reset{*this, "reset"};
//     reset.call(request, 200ms);                                      // in run(); goes on at once
//     if (reset.poll() == takt::CallStatus::replied) use(reset.reply());
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
#include <takt/component/service_type.hpp>
#include <takt/core/result.hpp>

namespace takt {

namespace detail {

/// What the present thread said by fail(); null when nothing.
const char* take_said() noexcept;

template <class T>
class RequestIn final : public InPort<ServiceRequest<T>> {
 public:
  RequestIn(Component* owner, const std::string& name, PortRole role, PortOptions options)
      // What comes for a handler is not run()'s to read, so it wakes no sporadic module.
      : InPort<ServiceRequest<T>>(owner, name + kRequestPort,
                                  role == PortRole::handler ? PortDirection::in : PortDirection::event,
                                  std::move(options)) {
    this->be(role);
  }
  using InPort<ServiceRequest<T>>::taken_from;
  /// The client does not wait for it any more.
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
    this->be(role);
  }
  using OutPort<ServiceReply<T>>::write_to;
};

template <class T>
class RequestOut final : public OutPort<ServiceRequest<T>> {
 public:
  RequestOut(Component* owner, const std::string& name, PortOptions options)
      : OutPort<ServiceRequest<T>>(owner, name + kRequestPort, {.text = std::move(options.text)}) {
    this->be(PortRole::client);
  }
  /// The beginning of the present run().
  [[nodiscard]] std::int64_t now_ns() const noexcept { return this->context().start_ns; }
};

template <class T>
class ReplyIn final : public InPort<ServiceReply<T>> {
 public:
  ReplyIn(Component* owner, const std::string& name, PortOptions options)
      : InPort<ServiceReply<T>>(owner, name + kReplyPort, PortDirection::event, std::move(options)) {
    this->be(PortRole::client);
  }
  void count_late_reply() noexcept { this->count_late(); }
};

}  // namespace detail

/// A service that a handler answers, as far as its types do not matter: for whoever runs the module.
class ServiceBase {
 public:
  ServiceBase(const ServiceBase&) = delete;
  ServiceBase& operator=(const ServiceBase&) = delete;
  virtual ~ServiceBase() = default;

  /// A request waits. For the thread that calls handle().
  [[nodiscard]] virtual bool has_request() const noexcept = 0;
  /// Takes one request and answers it: by the handler, or, where `refusal` is not null, with that. False when
  /// there was none. Not real-time; one thread at a time, beside the one that calls run().
  virtual bool handle(const char* refusal) = 0;

 protected:
  ServiceBase() = default;
  /// Whoever runs the component calls handle().
  void enlist(Component& owner);
};

/// Answers requests. Request and Reply are structs of IDL files, see takt_add_idl().
///
/// With a handler: it is called on a thread of the module's own that is not real-time, while the module is
/// EXECUTING; never at once with a hook other than run() and condition(), with which it shares what is
/// atomic, and nothing else (properties neither). It may allocate and wait, up to 5 s: later it is taken to
/// hang, as a hook. What it throws, or says by fail(), the client gets as a refusal. While the module is not
/// EXECUTING, requests are refused.
///
/// Without: run() takes requests and replies, on the real-time thread; everything but the constructor is for
/// it, and neither waits nor allocates. In a module that is not EXECUTING nobody takes them, and their
/// clients' time runs out. A request that waited for longer than its client does is refused and never taken.
template <class Request, class Reply>
class Service final : public ServiceBase {
 public:
  using Options = PortOptions;
  using Handler = std::function<Result<Reply>(const Request&)>;

  /// A template so that options in braces are no candidate for a handler.
  template <std::convertible_to<Handler> Callable>
  Service(Component& owner, const std::string& name, Callable handler, const Options& options = {})
      : Service(&owner, name, PortRole::handler, options) {
    handler_ = std::move(handler);
    enlist(owner);
  }
  Service(Component& owner, const std::string& name, const Options& options = {})
      : Service(&owner, name, PortRole::service, options) {}
  /// Of a program: a global variable, or one that is there before initPeriodExe() or initSporadicExe().
  explicit Service(const std::string& name, const Options& options = {})
      : Service(nullptr, name, PortRole::service, options) {}

  /// Goes on to the next request. False when none waits. One that was taken and not answered is forgotten.
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
      refuse("it came after its time-out (are the clocks of both devices together?)");
    }
    return false;
  }
  /// A request was taken and not answered.
  [[nodiscard]] bool busy() const noexcept { return busy_; }
  /// The one that was taken last; Request{} before the first. Good until the next take().
  [[nodiscard]] const Request& request() const noexcept { return in_.value().request; }
  /// Answers it. Once; without a request that waits for it this does nothing. A reply that is none of its
  /// type (a length beyond its bound) is a refusal that says so.
  void reply(const Reply& reply) noexcept {
    if (!busy_) return;
    if (!PortType<Reply>::fits(reply))
      return refuse("the reply is none of its type: a length beyond its bound");
    answer_.reply = reply;
    answer(ServiceCode::replied, {});
  }
  /// Answers it with why not; 127 bytes are kept.
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
    static_cast<void>(detail::take_said());
    try {
      const Result<Reply> result = handler_(request());
      if (const char* said = detail::take_said(); said != nullptr)
        refuse(said);
      else if (result)
        reply(*result);
      else
        refuse(in_words(result.problems()).c_str());
    } catch (const std::exception& exception) {
      refuse((std::string{"its handler threw: "} + exception.what()).c_str());
    } catch (...) {
      refuse("its handler threw something that is no std::exception");
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
    std::copy_n(reason.begin(), length, answer_.reason.begin());  // of no reason there is no address
    answer_.reason[length] = '\0';
    // The reply goes the way that belongs to the request's: the connections of both are made in one order.
    out_.write_to(from_, answer_);
  }

  detail::RequestIn<Request> in_;
  detail::ReplyOut<Reply> out_;
  Handler handler_;
  ServiceReply<Reply> answer_;
  std::size_t from_ = 0;
  bool busy_ = false;
};

enum class CallStatus {
  idle,       ///< call() was not called yet
  pending,    ///< the answer has not come
  replied,    ///< reply() is the answer
  refused,    ///< reason() says why
  timed_out,  ///< no answer came in time. Whether the service did it is not known.
  nobody,     ///< nobody serves: no <service> names the client, or the other device is not there
};
/// "idle", "pending", ...
const char* to_text(CallStatus status) noexcept;

/// Asks a service. Everything but the constructor is for every hook, above all for run(): it neither waits
/// nor allocates. One call at a time: a further one gives the former up. Time-outs are reckoned from the
/// beginning of the run() that called to the beginning of the one that polls. In a sporadic module an answer
/// is an event: it makes the module ready to run, which is to poll() then; a time-out is not.
template <class Request, class Reply>
class Client {
 public:
  using Options = PortOptions;

  Client(Component& owner, const std::string& name, const Options& options = {})
      : Client(&owner, name, options) {}
  explicit Client(const std::string& name, const Options& options = {}) : Client(nullptr, name, options) {}

  /// Sends a request. `pending`; or at once `nobody`, or `refused` for a request that is none of its type.
  CallStatus call(const Request& request, Nanoseconds timeout) noexcept {
    const std::int64_t now = out_.now_ns();
    // Another life of the module counts from 1 again: what was meant for the former one is not for this one.
    if (question_.client == 0) question_.client = static_cast<std::uint64_t>(now);
    ++question_.number;
    reason_ = "";
    if (!PortType<Request>::fits(request)) {
      reason_ = "the request is none of its type: a length beyond its bound";
      return status_ = CallStatus::refused;
    }
    if (!out_.connected()) return status_ = CallStatus::nobody;
    question_.request = request;
    question_.timeout_ns = timeout.count();
    out_.write(question_);
    until_ns_ = now + timeout.count();
    return status_ = CallStatus::pending;
  }

  /// Looks for the answer. Other than pending is said again until the next call().
  CallStatus poll() noexcept {
    while (in_.read()) {
      const ServiceReply<Reply>& answer = in_.value();
      if (answer.client != question_.client) continue;  // to a former life of this module
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
  /// As poll() found it last.
  [[nodiscard]] CallStatus status() const noexcept { return status_; }
  /// The last that came; Reply{} before the first.
  [[nodiscard]] const Reply& reply() const noexcept { return reply_; }
  /// Why it was refused; empty otherwise.
  [[nodiscard]] const char* reason() const noexcept { return reason_; }
  /// Answers that came when nobody waited for them any more; they were dropped.
  [[nodiscard]] std::uint64_t late() const noexcept { return late_; }
  /// Somebody serves.
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
