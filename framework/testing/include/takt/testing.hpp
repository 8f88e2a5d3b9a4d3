// What the author of a component includes to test it without a cell:
//
//   #include <takt/testing.hpp>
//
//   TEST(LowPass, PassesAConstant) {
//     takt::testing::Module module{{.period = 1ms}};
//     ASSERT_TRUE(module.set("cutoff", "10"));
//     auto& in = module.in<basic::Number>("in");
//     auto& out = module.out<basic::Number>("out");
//     ASSERT_TRUE(module.start());
//     in.write(number(1));
//     module.step(1000);
//     EXPECT_NEAR(out.value().value(), 1, 1e-6);
//   }
//
// with takt_add_component_test(low_pass low_pass_test.cpp) in CMake. It is the component that was built,
// called by the code that calls it in a cell, but on virtual time: no thread, no DDS, no clock, and a run()
// that takes no time. Works with any test framework: wrong use throws takt::testing::Error.
#pragma once

#include <algorithm>
#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <ostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <takt/channel/link.hpp>
#include <takt/component.hpp>
#include <takt/component/service_type.hpp>
#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/lifecycle/table.hpp>

namespace testing {
class AssertionResult;  // of GoogleTest, where it is used
}

namespace takt {
inline void PrintTo(ErrorType type, std::ostream* out) { *out << to_text(type); }
namespace lifecycle {
inline void PrintTo(State state, std::ostream* out) { *out << to_text(state); }
}  // namespace lifecycle
}  // namespace takt

namespace takt::testing {

/// A mistake of the test itself: a port that is not there, a step() before start().
class Error : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// What came of a call. ASSERT_TRUE(module.start()) prints the words of a failure.
class [[nodiscard]] Answer : public Result<void> {
 public:
  using Result<void>::Result;
  Answer(Result<void> result) : Result<void>(std::move(result)) {}  // NOLINT(google-explicit-constructor)
  /// "WHAT; FIX", one problem after the other; empty when it went well.
  [[nodiscard]] std::string text() const { return ok() ? std::string{} : in_words(problems()); }

  template <std::same_as<::testing::AssertionResult> Assertion>
  operator Assertion() const {  // NOLINT(google-explicit-constructor)
    Assertion assertion{ok()};
    return ok() ? assertion : assertion << text();
  }
};

/// What a module is told by its descriptor.
struct Options {
  /// Of a periodic module; of a sporadic one, how often it is looked whether it has to run.
  Nanoseconds period = std::chrono::milliseconds{1};
  bool sporadic = false;
  /// The .so of a thread module, or the .exe.so that takt_add_component_test() makes of a program. Empty: the
  /// component that takt_add_component_test() named.
  std::string file{};
};

/// How an input is connected.
struct Connection {
  std::uint32_t queue = 0;      ///< samples that it holds; 0: the latest value, of an event port 64
  Nanoseconds deadline{};       ///< a value that is older is late; 0: none is. Of thread modules
  bool stale_is_error = false;  ///< a value that is late takes the module to RECOVER
};

/// The last error that took the module out of its table.
struct Failure {
  ErrorType type = ErrorType::none;
  std::string text{};       ///< what run() said or threw
  std::uint64_t cycle = 0;  ///< in which it was
};

/// One connection between the test and a port.
class Wire {
 public:
  Wire(const TypeInfo& type, std::uint32_t depth, bool is_queue, Nanoseconds deadline);
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;
  virtual ~Wire() = default;
  [[nodiscard]] channel::Link link() const { return link_; }
  [[nodiscard]] const TypeInfo& type() const { return type_; }

 protected:
  /// A new step begins, and a run has ended.
  virtual void begin_step() {}
  virtual void collect() {}

 private:
  friend class Module;
  struct alignas(64) Line {
    std::byte bytes[64];
  };
  const TypeInfo& type_;
  std::shared_ptr<std::vector<Line>> memory_;
  channel::Link link_;
};

class Module;

/// What the test writes to an input or event port of the module.
template <class T>
class In final : public Wire {
 public:
  /// The next run() sees it `age` after the run() that wrote it began. Throws where the value is none of the
  /// type: a string or sequence beyond its bound, an enumerator that is none.
  void write(const T& value, Nanoseconds age = Nanoseconds{0});
  /// The output that the input is connected to has this safe value: the module gets it until the first
  /// write(), after lose(), and when what was written last is older than the connection's deadline. Throws as
  /// write(), and for a queue, whose readers get none.
  void safe(const T& value);
  /// The module that writes does not execute any more, or its device is lost; until the next write().
  void lose() { link().withhold(); }
  /// Times that the newest value was found older than the connection's deadline.
  [[nodiscard]] std::uint64_t late() const { return link().block().late.load(); }
  /// Samples that were overwritten before the module read them.
  [[nodiscard]] std::uint64_t overwritten() const { return link().block().overwritten.load(); }

 private:
  friend class Module;
  In(const Module& module, std::uint32_t depth, bool is_queue, Nanoseconds deadline)
      : Wire(PortType<T>::info, depth, is_queue, deadline), module_(module), writer_(link()) {}
  static std::uint32_t encode(const T& value, std::byte* to);
  const Module& module_;
  channel::LinkWriter writer_;
};

/// What an output port of the module has written, from out() on.
template <class T>
class Out final : public Wire {
 public:
  /// Of values(), the newest are kept.
  static constexpr std::size_t kMost = 100'000;

  [[nodiscard]] bool has_value() const { return has_value_; }
  /// The last one. Throws when there is none.
  [[nodiscard]] const T& value() const {
    if (!has_value_) throw Error("nothing was written to output '" + name_ + "' since out() was called");
    return value_;
  }
  /// Those of the last step(n), the oldest first; also those of hooks since then.
  [[nodiscard]] const std::deque<T>& values() const { return values_; }
  /// How many there were.
  [[nodiscard]] std::uint64_t count() const { return count_; }
  /// Values that were none of the type and went nowhere: a string or sequence beyond its bound.
  [[nodiscard]] std::uint64_t unfit() const { return link().block().unfit.load(); }

 private:
  friend class Module;
  Out(std::string name, std::uint32_t depth)
      : Wire(PortType<T>::info, depth, true, {}), name_(std::move(name)), reader_(link()) {
    PortType<T>::reserve(value_);
  }
  void begin_step() override { values_.clear(); }
  void collect() override;

  std::string name_;
  channel::LinkReader reader_;
  T value_{};
  bool has_value_ = false;
  std::deque<T> values_;
  std::uint64_t count_ = 0;
};

/// What came of Module::call(): a reply, or why there is none.
template <class Reply>
class [[nodiscard]] Called : public Answer {
 public:
  Called(Reply reply) : reply_(std::move(reply)) {}  // NOLINT(google-explicit-constructor)
  Called(Problem problem)
      : Answer(Result<void>(std::move(problem))) {}  // NOLINT(google-explicit-constructor)

  /// Throws where there is none, with text().
  [[nodiscard]] const Reply& value() const {
    if (!ok()) throw Error("there is no reply: " + text());
    return reply_;
  }
  const Reply& operator*() const { return value(); }
  const Reply* operator->() const { return &value(); }

 private:
  Reply reply_{};
};

/// What answers a client of the module.
class Responder {
 public:
  Responder() = default;
  Responder(const Responder&) = delete;
  Responder& operator=(const Responder&) = delete;
  virtual ~Responder() = default;

 private:
  friend class Module;
  virtual void answer(Instant now) = 0;
};

/// The service that a client of the module asks, see Module::serve().
template <class Request, class Reply>
class Server final : public Responder {
 public:
  using Handler = std::function<Result<Reply>(const Request&)>;

  /// How many requests there were.
  [[nodiscard]] std::uint64_t asked() const { return asked_; }
  /// The last one; Request{} before the first.
  [[nodiscard]] const Request& request() const { return request_; }

 private:
  friend class Module;
  struct Due {
    Instant at;
    ServiceReply<Reply> reply;
  };
  Server(Out<ServiceRequest<Request>>& requests, In<ServiceReply<Reply>>& replies, Handler handler,
         Nanoseconds after)
      : requests_(requests),
        replies_(replies),
        handler_(std::move(handler)),
        after_(after),
        seen_(requests.count()) {}
  void answer(Instant now) override;

  Out<ServiceRequest<Request>>& requests_;
  In<ServiceReply<Reply>>& replies_;
  Handler handler_;
  Nanoseconds after_;
  std::uint64_t seen_;  // of what was ever written there
  std::uint64_t asked_ = 0;
  Request request_{};
  std::deque<Due> due_;
};

/// One component, on virtual time. For one thread.
class Module {
 public:
  /// Loads it; its constructors run. Throws Error when that fails.
  explicit Module(Options options = {});
  /// Calls destruct() where it was initialised and that was not done.
  ~Module();
  Module(const Module&) = delete;
  Module& operator=(const Module&) = delete;

  /// A property, as the descriptor gives it before initialize(), and as `takt set` does after it: a value
  /// that a C++ component is given between two cycles is in force from the next one on.
  Answer set(const std::string& property, const std::string& text);
  /// The value of a property of a C++ component, or the one that was set.
  [[nodiscard]] Result<std::string> get(const std::string& property) const;

  /// Connects an input or event port, the first time that it is called for the port. The reference is good as
  /// long as the module. Throws Error with the ports that there are when it has no such port, or one of
  /// another direction or type. A port of which neither was called is one that nobody is connected to.
  template <class T>
  In<T>& in(const std::string& port);
  template <class T>
  In<T>& in(const std::string& port, const Connection& connection);
  /// The same for an output.
  template <class T>
  Out<T>& out(const std::string& port);

  /// Asks a service of the module as another module does, and steps until it answers: its reply, or why it
  /// refused, or that it had not answered when `timeout` was over. A handler is called between two rows,
  /// while the module is EXECUTING. Throws Error as in(), and as step().
  template <class Request, class Reply>
  Called<Reply> call(const std::string& service, const Request& request,
                     Nanoseconds timeout = std::chrono::seconds{1});
  /// Answers what the module's client `client` asks, by `handler`: a reply, or takt::fail("why not"). The
  /// module has it `after` later, at the earliest in its next run(); after its time-out, it is too late. The
  /// reference is good as long as the module. Once for each client; throws Error as in().
  template <class Request, class Reply>
  Server<Request, Reply>& serve(const std::string& client, typename Server<Request, Reply>::Handler handler,
                                Nanoseconds after = Nanoseconds{0});

  // The lifecycle, as framework/lifecycle says: what is not allowed in a state is refused with the states in
  // which it is, and changes nothing.

  Answer initialize();
  /// From IDLE also initialize(). Into the tables.
  Answer start();
  /// Out of the tables.
  Answer stop();
  /// An error of this type comes upon it, as from outside.
  Answer error(ErrorType type);
  /// Its process dies under it, and no hook is called: RECOVER, with an error of type crash. recover() loads
  /// it again, and what it saves comes back to it.
  Answer crash();
  /// One attempt. A program that ended is started again.
  Answer recover();
  Answer destruct();
  /// Loaded afresh. What was set and connected stays, and what it saved is gone.
  Answer reset();
  [[nodiscard]] lifecycle::State state() const;

  /// That many releases of its grid, one after the other; returns in how many the module ran (a sporadic one
  /// when its condition held). In RECOVER and DESTRUCT time passes and nothing is called. Throws Error where
  /// start() was never called.
  std::uint64_t step(std::uint64_t releases = 1);
  /// Until `done()` holds after a release: true. False when it did not within `most`.
  template <std::predicate Done>
  bool step_until(Done&& done, std::uint64_t most = 1'000'000) {
    for (std::uint64_t n = 0; n < most; ++n) {
      step();
      if (done()) return true;
    }
    return false;
  }
  /// The next releases are missed, as when the machine was busy: the cycle's number has a gap.
  void miss(std::uint64_t releases = 1);

  /// When the next release is due, and which it is on the module's grid.
  [[nodiscard]] Instant next_release() const;
  /// Times that it ran, or, of a program, was released.
  [[nodiscard]] std::uint64_t runs() const;
  [[nodiscard]] std::uint64_t missed() const;
  /// The last error, of type none where there was none.
  [[nodiscard]] const Failure& last_error() const;
  /// Fails with the words of the last error while the module is in RECOVER.
  [[nodiscard]] Answer healthy() const;

 private:
  enum class Side { in, out };
  struct Tie {
    Wire* wire = nullptr;  // that there is already
    std::uint32_t queue = 0;
  };
  Tie find(const std::string& port, Side side, const TypeInfo& type, const Connection* wanted) const;
  void tie(const std::string& port, std::unique_ptr<Wire> wire, const Connection& connection);
  /// So many samples that one run() hardly writes more, in memory that is bounded.
  static std::uint32_t most_of_a_run(const TypeInfo& type);
  /// Throws where there is none of these types.
  void find_service(const std::string& name, bool is_client, const TypeInfo& request,
                    const TypeInfo& reply) const;
  void respond(const std::string& client, std::unique_ptr<Responder> responder);
  /// Of the call that comes next.
  std::uint64_t call_number();

  struct Inside;
  std::unique_ptr<Inside> inside_;
};

template <class T>
std::uint32_t In<T>::encode(const T& value, std::byte* to) {
  const std::uint32_t size = PortType<T>::encode(value, to, PortType<T>::info.max_size);
  if (size != 0) return size;
  throw Error("the value is no " + std::string{PortType<T>::info.name} +
              ": a string or sequence is longer than its bound, or an enumerator is none");
}

template <class T>
void In<T>::safe(const T& value) {
  if (!link().has_safe_place()) throw Error("readers of a queue get no safe value");
  std::vector<std::byte> bytes(PortType<T>::info.max_size);
  bytes.resize(encode(value, bytes.data()));
  link().give_safe(bytes);
}

template <class T>
void In<T>::write(const T& value, Nanoseconds age) {
  const std::uint32_t size = encode(value, link().payload(writer_.buffer()));
  link().trust();
  writer_.publish(size, to_ns(module_.next_release() - age));
}

template <class T>
void Out<T>::collect() {
  while (reader_.take()) {
    const channel::SampleInfo info = reader_.info();
    if (!PortType<T>::decode(link().payload(reader_.buffer()), info.size, value_))
      throw Error("what was written to output '" + name_ + "' is no " + PortType<T>::info.name);
    has_value_ = true;
    ++count_;
    if (values_.size() == kMost) values_.pop_front();
    values_.push_back(value_);
  }
}

template <class T>
In<T>& Module::in(const std::string& port) {
  const Tie tied = find(port, Side::in, PortType<T>::info, nullptr);
  if (tied.wire != nullptr) return static_cast<In<T>&>(*tied.wire);
  return in<T>(port, Connection{});
}

template <class T>
In<T>& Module::in(const std::string& port, const Connection& connection) {
  const Tie tied = find(port, Side::in, PortType<T>::info, &connection);
  const bool is_queue = tied.queue != 0;
  std::unique_ptr<In<T>> wire{new In<T>(*this, is_queue ? tied.queue : 1, is_queue, connection.deadline)};
  In<T>& result = *wire;
  tie(port, std::move(wire), connection);
  return result;
}

template <class T>
Out<T>& Module::out(const std::string& port) {
  const Tie tied = find(port, Side::out, PortType<T>::info, nullptr);
  if (tied.wire != nullptr) return static_cast<Out<T>&>(*tied.wire);
  std::unique_ptr<Out<T>> wire{new Out<T>(port, most_of_a_run(PortType<T>::info))};
  Out<T>& result = *wire;
  tie(port, std::move(wire), Connection{});
  return result;
}

template <class Request, class Reply>
Called<Reply> Module::call(const std::string& service, const Request& request, Nanoseconds timeout) {
  find_service(service, false, PortType<Request>::info, PortType<Reply>::info);
  auto& requests = in<ServiceRequest<Request>>(service + kRequestPort);
  auto& replies = out<ServiceReply<Reply>>(service + kReplyPort);
  const std::uint64_t number = call_number();
  requests.write({.client = 1, .number = number, .timeout_ns = timeout.count(), .request = request});
  for (const Instant until = next_release() + timeout; next_release() <= until;) {
    step();
    for (const ServiceReply<Reply>& answer : replies.values()) {
      if (answer.number != number) continue;
      if (answer.code == ServiceCode::replied) return answer.reply;
      return fail(answer.reason.data());
    }
  }
  return fail("no reply came within " + to_text(timeout));
}

template <class Request, class Reply>
Server<Request, Reply>& Module::serve(const std::string& client,
                                      typename Server<Request, Reply>::Handler handler, Nanoseconds after) {
  find_service(client, true, PortType<Request>::info, PortType<Reply>::info);
  auto& requests = out<ServiceRequest<Request>>(client + kRequestPort);
  auto& replies = in<ServiceReply<Reply>>(client + kReplyPort);
  std::unique_ptr<Server<Request, Reply>> server{
      new Server<Request, Reply>(requests, replies, std::move(handler), after)};
  Server<Request, Reply>& result = *server;
  respond(client, std::move(server));
  return result;
}

template <class Request, class Reply>
void Server<Request, Reply>::answer(Instant now) {
  for (; seen_ < requests_.count(); ++seen_) {
    const auto& asked = requests_.values().at(requests_.values().size() - (requests_.count() - seen_));
    ++asked_;
    request_ = asked.request;
    ServiceReply<Reply> reply{.client = asked.client, .number = asked.number};
    Result<Reply> result = handler_(request_);
    if (result) {
      reply.reply = std::move(*result);
    } else {
      reply.code = ServiceCode::refused;
      const std::string words = in_words(result.problems());
      std::copy_n(words.begin(), std::min(words.size(), kReasonLength), reply.reason.begin());
    }
    due_.push_back({now + after_, std::move(reply)});
  }
  for (; !due_.empty() && due_.front().at <= now; due_.pop_front()) replies_.write(due_.front().reply);
}

}  // namespace takt::testing
