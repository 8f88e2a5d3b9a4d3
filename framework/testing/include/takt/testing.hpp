// The header for tests of a component without a cell:
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
// In CMake, takt_add_component_test(low_pass low_pass_test.cpp) builds and registers the test. The test runs
// the built component. The component is called by the same code as in a cell, but on virtual time: there are
// no threads, no DDS and no clock, and run() takes no time. The harness works with any test framework: wrong
// use throws takt::testing::Error.
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
class AssertionResult;  // of GoogleTest, if the test uses it
}

namespace takt {
/// For GoogleTest: prints the name of an error type in messages.
inline void PrintTo(ErrorType type, std::ostream* out) { *out << to_text(type); }
namespace lifecycle {
/// For GoogleTest: prints the name of a state in messages.
inline void PrintTo(State state, std::ostream* out) { *out << to_text(state); }
}  // namespace lifecycle
}  // namespace takt

/// Tests of a component without a cell, see takt::testing::Module.
namespace takt::testing {

/// Thrown for a mistake in the test itself, such as an unknown port, or step() before start().
class Error : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// The outcome of a call. If it is a failure, ASSERT_TRUE(module.start()) prints the reason.
class [[nodiscard]] Answer : public Result<void> {
 public:
  using Result<void>::Result;
  /// This conversion is implicit, so that functions can return a Result.
  Answer(Result<void> result) : Result<void>(std::move(result)) {}  // NOLINT(google-explicit-constructor)
  /// "WHAT; FIX" for each problem, separated by ". "; empty if the call succeeded.
  [[nodiscard]] std::string text() const { return ok() ? std::string{} : in_words(problems()); }

  /// Conversion for GoogleTest's ASSERT_TRUE and EXPECT_TRUE.
  template <std::same_as<::testing::AssertionResult> Assertion>
  operator Assertion() const {  // NOLINT(google-explicit-constructor)
    Assertion assertion{ok()};
    return ok() ? assertion : assertion << text();
  }
};

/// What the descriptor of a cell would state about the module.
struct Options {
  /// The period of a periodic module, in whole nanoseconds above 0. For a sporadic module, the time between
  /// two checks of its condition.
  Nanoseconds period = std::chrono::milliseconds{1};
  bool sporadic = false;  ///< true: the module is sporadic; false: it is periodic
  /// The .so of a thread module, or the .exe.so that takt_add_component_test() builds from a program. Empty:
  /// the component that takt_add_component_test() named. A relative path is searched in the folder of that
  /// component, then in the folders of TAKT_COMPONENT_PATH.
  std::string file{};
};

/// How an input is connected.
struct Connection {
  std::uint32_t queue = 0;  ///< number of samples that the queue holds. 0: the input holds only the latest
                            ///< value; an event port has a queue of 64 samples
  Nanoseconds deadline{};   ///< a value older than this is late; 0: no deadline. Thread modules only
  bool stale_is_error = false;  ///< true: a late value takes the module to RECOVER
};

/// The last error that took the module out of its table.
struct Failure {
  ErrorType type = ErrorType::none;  ///< the type of the error; none if there was no error
  std::string text{};                ///< the text of the exception, or the text that the module passed to
                                     ///< fail()
  std::uint64_t cycle = 0;           ///< the number of the release in which the error occurred
};

/// A line that the module has logged.
struct Logged {
  LogLevel level = LogLevel::info;  ///< how important the line is
  std::uint64_t cycle = 0;          ///< the number of the release in which the module logged the line
                                    ///< (takt::Cycle::number); 0 if a hook other than run() logged it
  std::string text{};               ///< the text, with its arguments
};

/// One connection between the test and a port.
class TestLink {
 public:
  /// Only Module calls this; use Module::in() and Module::out().
  TestLink(const TypeInfo& type, std::uint32_t depth, bool is_queue, Nanoseconds deadline);
  TestLink(const TestLink&) = delete;
  TestLink& operator=(const TestLink&) = delete;
  virtual ~TestLink() = default;
  /// The link between the test and the port.
  [[nodiscard]] channel::Link link() const { return link_; }
  /// The type of the port's samples.
  [[nodiscard]] const TypeInfo& type() const { return type_; }

 protected:
  /// Called at the beginning of each step().
  virtual void begin_step() {}
  /// Called after each release and after each hook of the module.
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

/// The test's side of an input or event port of the module.
template <class T>
class In final : public TestLink {
 public:
  /// Sends a sample that has this `age` at the next release. Throws Error if the value does not fit its type:
  /// a string or sequence exceeds its bound, or an enumerator is invalid.
  void write(const T& value, Nanoseconds age = Nanoseconds{0});
  /// Sets the safe value of the simulated output that feeds this input. The module gets the safe value until
  /// the first write(), after lose(), and when the last sample is older than the connection's deadline.
  /// Throws Error in the same cases as write(), and also for a queue, which has no safe value.
  void safe(const T& value);
  /// Simulates that the writing module stops or its device is lost. The next write() ends this state.
  void lose() { link().withhold(); }
  /// The number of times that the newest value was older than the connection's deadline.
  [[nodiscard]] std::uint64_t late() const { return link().block().late.load(); }
  /// The number of samples that were overwritten before the module read them.
  [[nodiscard]] std::uint64_t overwritten() const { return link().block().overwritten.load(); }

 private:
  friend class Module;
  In(const Module& module, std::uint32_t depth, bool is_queue, Nanoseconds deadline)
      : TestLink(PortType<T>::info, depth, is_queue, deadline), module_(module), writer_(link()) {}
  static std::uint32_t encode(const T& value, std::byte* to);
  const Module& module_;
  channel::LinkWriter writer_;
};

/// The test's side of an output port of the module. It receives the values that the module writes after out()
/// was called.
template <class T>
class Out final : public TestLink {
 public:
  /// The maximum number of values in values(), which keeps the newest ones.
  static constexpr std::size_t kMost = 100'000;

  /// True if the module has written a value since out() was called.
  [[nodiscard]] bool has_value() const { return has_value_; }
  /// The last value that the module wrote. Throws Error if there is none.
  [[nodiscard]] const T& value() const {
    if (!has_value_) throw Error("nothing was written to output '" + name_ + "' since out() was called");
    return value_;
  }
  /// The values that the module wrote during the last step() and in hooks since then, the oldest first.
  [[nodiscard]] const std::deque<T>& values() const { return values_; }
  /// The number of all values since out() was called.
  [[nodiscard]] std::uint64_t count() const { return count_; }
  /// The number of values that the module wrote but that were not sent, because they did not fit their type:
  /// a string or sequence exceeded its bound, or an enumerator was invalid.
  [[nodiscard]] std::uint64_t unfit() const { return link().block().unfit.load(); }

 private:
  friend class Module;
  Out(std::string name, std::uint32_t depth)
      : TestLink(PortType<T>::info, depth, true, {}), name_(std::move(name)), reader_(link()) {
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

/// The outcome of Module::call(): a reply, or the reason why there is none.
template <class Reply>
class [[nodiscard]] Called : public Answer {
 public:
  /// Constructs an outcome with a reply.
  Called(Reply reply) : reply_(std::move(reply)) {}  // NOLINT(google-explicit-constructor)
  /// Constructs an outcome without a reply. The problem is the reason.
  Called(Problem problem)
      : Answer(Result<void>(std::move(problem))) {}  // NOLINT(google-explicit-constructor)

  /// The reply. Throws Error with text() if there is none.
  [[nodiscard]] const Reply& value() const {
    if (!ok()) throw Error("there is no reply: " + text());
    return reply_;
  }
  /// The reply, see value().
  const Reply& operator*() const { return value(); }
  /// The reply, see value().
  const Reply* operator->() const { return &value(); }

 private:
  Reply reply_{};
};

/// The base of Server.
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

/// The service that a client of the module calls, see Module::serve().
template <class Request, class Reply>
class Server final : public Responder {
 public:
  /// The function that answers a request. Returns a reply, or takt::fail("why not").
  using Handler = std::function<Result<Reply>(const Request&)>;

  /// The number of requests that the client has sent so far.
  [[nodiscard]] std::uint64_t asked() const { return asked_; }
  /// The last request that the client sent; Request{} before the first request.
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
  std::uint64_t seen_;  // number of requests that this server has already processed
  std::uint64_t asked_ = 0;
  Request request_{};
  std::deque<Due> due_;
};

/// A module of one component, on virtual time. Only one thread may use it.
class Module {
 public:
  /// Loads the component and runs its constructors. Throws Error if this fails.
  explicit Module(Options options = {});
  /// Calls destruct() if the module is neither in IDLE nor in DESTRUCT.
  ~Module();
  Module(const Module&) = delete;
  Module& operator=(const Module&) = delete;

  /// Sets a property: before initialize() as the descriptor does, and afterwards as `takt set` does. A C++
  /// component, and a program that declares properties, see a value that is set between two cycles from the
  /// next cycle on. Other modules take properties only before initialize(). Every module takes `log-level` at
  /// any time.
  Answer set(const std::string& property, const std::string& text);
  /// The value of a property. For a C++ component, and for a program that declares properties and runs, this
  /// is the current value, otherwise the value that was set last.
  [[nodiscard]] Result<std::string> get(const std::string& property) const;

  /// Connects an input or event port with the default Connection; further calls for the port return the same
  /// object. The reference is valid as long as the module exists. Throws Error if the module has no such
  /// port, or if the port has another direction or type. A port is unconnected until in() or out() names it.
  template <class T>
  In<T>& in(const std::string& port);
  /// Connects an input or event port with this Connection; otherwise like in(port). Also throws Error if the
  /// port is connected already.
  template <class T>
  In<T>& in(const std::string& port, const Connection& connection);
  /// Connects an output; otherwise like in(port).
  template <class T>
  Out<T>& out(const std::string& port);

  /// Calls a service of the module, as another module does, and steps until there is an answer. Returns the
  /// reply, the reason for a rejection, or a failure if no answer came within `timeout`. A handler is called
  /// between two rows, while the module is EXECUTING. Throws Error like in() and step().
  template <class Request, class Reply>
  Called<Reply> call(const std::string& service, const Request& request,
                     Nanoseconds timeout = std::chrono::seconds{1});
  /// Answers the requests of the module's client `client` with `handler`, which returns a reply or
  /// takt::fail("why not"). The answer arrives `after` later, at the earliest in the next run(). The
  /// reference is valid as long as the module exists. Call serve() once for each client. Throws Error like
  /// in().
  template <class Request, class Reply>
  Server<Request, Reply>& serve(const std::string& client, typename Server<Request, Reply>::Handler handler,
                                Nanoseconds after = Nanoseconds{0});

  // The lifecycle, see framework/lifecycle. If a step is not allowed in the current state, nothing changes,
  // and the problem names the states in which it is allowed.

  /// Calls the hook initialize(). The state changes from IDLE to INITIALIZE.
  Answer initialize();
  /// Calls the hook start() and puts the module into the tables. In IDLE it calls initialize() first.
  Answer start();
  /// Takes the module out of the tables. The state changes from EXECUTING to START.
  Answer stop();
  /// Causes an error of this type from outside: the module goes to RECOVER, and its hook error() is called.
  Answer error(ErrorType type);
  /// Simulates the death of the module's process, without calling a hook: the module goes to RECOVER with an
  /// error of type crash. recover() then loads the module again, and the module gets its saved state back.
  Answer crash();
  /// Makes one recovery attempt. If the program of a process module has ended, starts it again.
  Answer recover();
  /// Takes the module out of the tables and calls the hook destruct(). The state changes to DESTRUCT.
  Answer destruct();
  /// Loads the module again. The state changes from DESTRUCT to IDLE. Properties and connections stay; the
  /// saved state is lost.
  Answer reset();
  /// The current state.
  [[nodiscard]] lifecycle::State state() const;

  /// Performs this many releases of the module's grid. Returns the number of releases in which the module
  /// ran: a sporadic thread module runs if its condition is true, a sporadic program in each release. A
  /// module that finishes goes to DESTRUCT. In RECOVER and DESTRUCT only time passes. Throws Error if start()
  /// was never called.
  std::uint64_t step(std::uint64_t releases = 1);
  /// Steps until `done()` is true after a release, and returns true. Returns false after `most` releases.
  template <std::predicate Done>
  bool step_until(Done&& done, std::uint64_t most = 1'000'000) {
    for (std::uint64_t n = 0; n < most; ++n) {
      step();
      if (done()) return true;
    }
    return false;
  }
  /// Makes the module miss its next releases, as if the machine was busy. The numbers of its releases then
  /// have a gap.
  void miss(std::uint64_t releases = 1);

  /// The virtual time at which the next release is due.
  [[nodiscard]] Instant next_release() const;
  /// The number of times that the module ran. For a process module: the number of its releases.
  [[nodiscard]] std::uint64_t runs() const;
  /// The number of releases that the module missed.
  [[nodiscard]] std::uint64_t missed() const;
  /// The last error; of type none if there was none.
  [[nodiscard]] const Failure& last_error() const;
  /// All lines that the module has logged, the oldest first. A test sees every line, because the harness does
  /// not limit the rate.
  [[nodiscard]] const std::vector<Logged>& log() const;
  /// True if the module has reported that it is in a safe stop.
  [[nodiscard]] bool in_safe_stop() const;
  /// Succeeds unless the module is in RECOVER. In RECOVER, fails with the text of the last error.
  [[nodiscard]] Answer healthy() const;

 private:
  enum class Side { in, out };
  struct Tie {
    TestLink* link = nullptr;  // the existing connection; null: none
    std::uint32_t queue = 0;
  };
  Tie find(const std::string& port, Side side, const TypeInfo& type, const Connection* wanted) const;
  void tie(const std::string& port, std::unique_ptr<TestLink> link, const Connection& connection);
  /// The depth of an output's queue: enough for the samples that one run() is expected to write, but within a
  /// memory limit.
  static std::uint32_t most_of_a_run(const TypeInfo& type);
  /// Throws Error if the module has no service or client with this name and these types.
  void find_service(const std::string& name, bool is_client, const TypeInfo& request,
                    const TypeInfo& reply) const;
  void respond(const std::string& client, std::unique_ptr<Responder> responder);
  /// Returns a new number, for the next call of a service.
  std::uint64_t call_number();

  struct Inside;
  std::unique_ptr<Inside> inside_;
};

template <class T>
std::uint32_t In<T>::encode(const T& value, std::byte* to) {
  const std::uint32_t size = PortType<T>::encode(value, to, PortType<T>::info.max_size);
  if (size != 0) return size;
  throw Error("the value does not fit type " + std::string{PortType<T>::info.name} +
              ": a string or sequence is longer than its bound, or an enumerator is invalid");
}

template <class T>
void In<T>::safe(const T& value) {
  if (!link().has_safe_place())
    throw Error("an input with a queue has no safe value; connect it without a queue");
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
      throw Error("output '" + name_ + "' has written bytes that are not a valid " + PortType<T>::info.name);
    has_value_ = true;
    ++count_;
    if (values_.size() == kMost) values_.pop_front();
    values_.push_back(value_);
  }
}

template <class T>
In<T>& Module::in(const std::string& port) {
  const Tie tied = find(port, Side::in, PortType<T>::info, nullptr);
  if (tied.link != nullptr) return static_cast<In<T>&>(*tied.link);
  return in<T>(port, Connection{});
}

template <class T>
In<T>& Module::in(const std::string& port, const Connection& connection) {
  const Tie tied = find(port, Side::in, PortType<T>::info, &connection);
  const bool is_queue = tied.queue != 0;
  std::unique_ptr<In<T>> link{new In<T>(*this, is_queue ? tied.queue : 1, is_queue, connection.deadline)};
  In<T>& result = *link;
  tie(port, std::move(link), connection);
  return result;
}

template <class T>
Out<T>& Module::out(const std::string& port) {
  const Tie tied = find(port, Side::out, PortType<T>::info, nullptr);
  if (tied.link != nullptr) return static_cast<Out<T>&>(*tied.link);
  std::unique_ptr<Out<T>> link{new Out<T>(port, most_of_a_run(PortType<T>::info))};
  Out<T>& result = *link;
  tie(port, std::move(link), Connection{});
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
