// Does something that endangers the other modules of its host. The property `deed` names it, and `hook` the
// hook in which it happens: once, and in run() only in the `after`-th call. If the environment variable
// TRESPASSES_AT_LOAD is set, it names what happens when the component is loaded.
#include <takt/component.hpp>

#include <pthread.h>
#include <signal.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <thread>

namespace {

void* crashes(void*) {
  *static_cast<volatile int*>(nullptr) = 1;
  return nullptr;
}
void handle(int) {}
void start_timers() {
  const itimerval every_ms{{0, 1000}, {0, 1000}};
  setitimer(ITIMER_REAL, &every_ms, nullptr);
  setitimer(ITIMER_PROF, &every_ms, nullptr);
  timer_t timer{};
  sigevent event{};
  event.sigev_notify = SIGEV_SIGNAL;
  event.sigev_signo = SIGRTMIN;
  const itimerspec every{{0, 1000000}, {0, 1000000}};
  if (timer_create(CLOCK_MONOTONIC, &event, &timer) == 0) timer_settime(timer, 0, &every, nullptr);
}

volatile long expired = 0;
void start_thread_timer(void (*expire)(sigval)) {
  timer_t timer{};
  sigevent event{};
  event.sigev_notify = SIGEV_THREAD;
  event.sigev_notify_function = expire;
  const itimerspec every{{0, 1000000}, {0, 1000000}};
  if (timer_create(CLOCK_MONOTONIC, &event, &timer) == 0) timer_settime(timer, 0, &every, nullptr);
}

void throw_int() { throw 42; }
void throw_in_noexcept() noexcept { throw_int(); }

void* runs_on(void*) {
  while (true) usleep(1000);
}
void* exits(void*) { std::exit(3); }
void* starts_another(void*) {
  std::thread{[] { std::abort(); }}.join();
  return nullptr;
}

void start_thread(void* (*body)(void*)) {
  pthread_t thread{};
  if (pthread_create(&thread, nullptr, body, nullptr) == 0) pthread_detach(thread);
}

void commit(const std::string& deed) {
  if (deed == "_exit") _exit(3);
  if (deed == "_Exit") std::_Exit(3);
  if (deed == "quick_exit") std::quick_exit(3);
  if (deed == "exit_group") syscall(SYS_exit_group, 3);  // passes by the C library
  if (deed == "crashing thread") start_thread(crashes);
  if (deed == "timers") start_timers();
  if (deed == "handled timers") {
    for (const int number : {SIGALRM, SIGPROF, SIGRTMIN}) signal(number, handle);
    start_timers();
  }
  if (deed == "thread timer") start_thread_timer([](sigval) { expired = expired + 1; });
  if (deed == "crashing timer") start_thread_timer([](sigval) { crashes(nullptr); });
  if (deed == "close") {
    for (int fd = 0; fd < 1024; ++fd) close(fd);
  }
  if (deed == "close_range") close_range(3, ~0U, 0);
  if (deed == "closefrom") closefrom(0);
  if (deed == "close own") close(dup(0));
  if (deed == "pthread_exit") pthread_exit(nullptr);
  if (deed == "throw") throw_int();
  if (deed == "throw in noexcept") throw_in_noexcept();
  if (deed == "handler of SIGSEGV") signal(SIGSEGV, handle);
  if (deed == "endless thread") start_thread(runs_on);
  if (deed == "exiting thread") start_thread(exits);
  if (deed == "thread of a thread") start_thread(starts_another);
  if (deed == "fork_exit") {
    const pid_t child = fork();
    if (child == 0) _exit(3);
    waitpid(child, nullptr, 0);
  }
}

struct AtLoad {
  AtLoad() {
    if (const char* deed = std::getenv("TRESPASSES_AT_LOAD"); deed != nullptr) commit(deed);
  }
};
const AtLoad at_load;

}  // namespace

class Trespasses : public takt::Component {
  takt::Property<std::string> deed{*this, "deed", ""};
  takt::Property<std::string> hook{*this, "hook", "run"};
  takt::Property<std::int64_t> after{*this, "after", 100};
  std::int64_t runs_ = 0;

  void enter(const std::string& name) {
    const std::string& mine = hook;
    const std::string& what = deed;
    if (name == mine) commit(what);
  }
  takt::Result<void> initialize() override {
    enter("initialize");
    return {};
  }
  takt::Result<void> start() override {
    enter("start");
    return {};
  }
  void run(const takt::Cycle&) override {
    if (++runs_ != after) return;
    const std::string& name = hook;
    enter("run");
    if (name == "error" || name == "recover") throw std::runtime_error("to call " + name + "()");
  }
  void error(takt::ErrorType) override { enter("error"); }
  takt::Result<void> recover() override {
    enter("recover");
    return {};
  }
  void destruct() override { enter("destruct"); }
};
TAKT_COMPONENT(Trespasses)
