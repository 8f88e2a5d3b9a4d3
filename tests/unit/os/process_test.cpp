#include <takt/os/process.hpp>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#include <folders.hpp>
#include <long_enough.hpp>

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <takt/os/clock.hpp>
#include <takt/os/machine.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/sealed_copy.hpp>
#include <takt/os/shared_memory.hpp>

namespace takt::os::process_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;

SpawnOptions shell(const std::string& script) { return {.program = "/bin/sh", .arguments = {"-c", script}}; }

std::string read_all(const Fd& fd) {
  std::string text;
  for (bool end = false; !end;) {
    pollfd wanted{.fd = fd.get(), .events = POLLIN, .revents = 0};
    ::poll(&wanted, 1, -1);
    text += read_available(fd, &end);
  }
  return text;
}

// The process that adopts an orphaned process may reap it late, so a zombie counts as dead.
bool is_dead(int pid) {
  if (::kill(pid, 0) != 0) return true;
  std::ifstream file{"/proc/" + std::to_string(pid) + "/stat"};
  std::string state;
  return !(file >> state >> state >> state) || state == "Z" || state == "X";
}

void expect_death(int pid) {
  const Instant limit = now() + long_enough();
  while (!is_dead(pid) && now() < limit) sleep_until(now() + milliseconds{1});
  EXPECT_TRUE(is_dead(pid));
}

TEST(Child, ReportsItsExitStatus) {
  auto child = Child::spawn(shell("exit 3"));
  ASSERT_TRUE(child.ok());
  const ProcessEnd end = child->wait();
  EXPECT_FALSE(end.signalled);
  EXPECT_EQ(end.code, 3);
  EXPECT_EQ(end.text(), "ended with status 3");
  EXPECT_FALSE(child->running());
}

TEST(Child, ReportsTheSignalThatKilledIt) {
  auto child = Child::spawn(shell("kill -SEGV $$"));
  const ProcessEnd end = child->wait();
  EXPECT_TRUE(end.signalled);
  EXPECT_EQ(end.code, SIGSEGV);
  EXPECT_EQ(end.text(), "was killed by SIGSEGV (Segmentation fault)");
}

TEST(Child, ReportsItsEndOnlyOnce) {
  auto child = Child::spawn({.program = "/bin/sleep", .arguments = {"100"}});
  EXPECT_EQ(child->poll(), std::nullopt);
  EXPECT_TRUE(child->running());
  child->signal(kTerminate);
  std::optional<ProcessEnd> end;
  while (!end) {
    end = child->poll();
    sleep_until(now() + milliseconds{1});
  }
  EXPECT_EQ(end->code, SIGTERM);
  EXPECT_EQ(child->poll(), std::nullopt);
  EXPECT_FALSE(child->running());
}

TEST(Child, IsReapedAWhileAfterItsEndWasReported) {
  auto child = Child::spawn(shell("exit 3"));
  const int pid = child->pid();
  std::optional<ProcessEnd> end;
  while (!end) end = child->poll();
  EXPECT_EQ(end->text(), "ended with status 3");
  EXPECT_EQ(::kill(pid, 0), 0) << "the report must not wait until the kernel has removed the process";
  *child = std::move(*Child::spawn({.program = "/bin/sleep", .arguments = {"100"}}));
  const Instant limit = now() + long_enough();
  while (::kill(pid, 0) == 0 && now() < limit) {
    EXPECT_EQ(child->poll(), std::nullopt);
    sleep_until(now() + milliseconds{1});
  }
  EXPECT_NE(::kill(pid, 0), 0) << "the object reaps the former process, too";
  EXPECT_TRUE(child->running());
}

TEST(Child, IsReapedByItsDestructor) {
  int pid = 0;
  {
    auto child = Child::spawn(shell("exit 3"));
    pid = child->pid();
    while (!child->poll()) sleep_until(now() + milliseconds{1});
  }
  EXPECT_NE(::kill(pid, 0), 0);
}

TEST(Child, ReportsWhyAProgramCannotBeExecuted) {
  const auto missing = Child::spawn({.program = "/nowhere/program"});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.problems()[0].what, "/nowhere/program: No such file or directory");
  const auto no_program = Child::spawn({.program = source_path("CMakeLists.txt")});
  ASSERT_FALSE(no_program.ok());
  EXPECT_THAT(no_program.problems()[0].what, HasSubstr("Permission denied"));
  errno = 0;
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "no process is left";
  EXPECT_EQ(errno, ECHILD);
}

TEST(Child, CanHaveItsOutputCaptured) {
  SpawnOptions options = shell("echo out; echo err >&2; cat; echo \"$TAKT_TEST\"");
  options.capture_output = true;
  options.environment = {{"TAKT_TEST", "told"}};
  auto child = Child::spawn(options);
  ASSERT_TRUE(child.ok());
  EXPECT_EQ(read_all(child->output), "out\ntold\n") << "cat must find an empty input";
  EXPECT_EQ(read_all(child->error), "err\n");
  EXPECT_EQ(child->wait().code, 0);
}

TEST(Child, RunsOnTheGivenCpusFromItsFirstInstruction) {
  SpawnOptions options = shell("grep Cpus_allowed_list /proc/self/status");
  options.cpus = {read_cpus().ordinary.back()};
  options.capture_output = true;
  auto child = Child::spawn(options);
  ASSERT_TRUE(child.ok());
  EXPECT_EQ(read_all(child->output), "Cpus_allowed_list:\t" + std::to_string(options.cpus[0]) + "\n");
  child->wait();
}

TEST(Child, InheritsOnlyTheGivenFileDescriptors) {
  const auto handed = SharedMemory::create("handed", 4096);
  const auto kept = SharedMemory::create("kept", 4096);
  SpawnOptions options = shell("test -e /proc/self/fd/" + std::to_string(handed->fd().get()) +
                               " && ! test -e /proc/self/fd/" + std::to_string(kept->fd().get()));
  options.inherit = {&handed->fd()};
  auto child = Child::spawn(options);
  EXPECT_EQ(child->wait().code, 0);
}

TEST(Child, ExecutesACopyInsteadOfTheFile) {
  const auto copy = sealed_copy("/bin/sh");
  SpawnOptions options{.program = "/nowhere/program",
                       .copy = &*copy,
                       .arguments = {"-c",
                                     "echo \"$0\"; tr '\\0' ' ' < /proc/$$/cmdline; readlink /proc/$$/exe; "
                                     "test ! -e /proc/$$/fd/" +
                                         std::to_string(copy->get())},
                       .capture_output = true};
  auto child = Child::spawn(options);
  ASSERT_TRUE(child.ok()) << to_text(child.problems());
  EXPECT_THAT(read_all(child->output),
              testing::MatchesRegex("/nowhere/program\n/nowhere/program -c .*/memfd:sh .*\n"));
  EXPECT_EQ(child->wait().code, 0);
}

TEST(Child, ExecutesTheCopyOfAScript) {
  const std::string path = testing::TempDir() + "takt-script-" + std::to_string(::getpid());
  std::ofstream{path} << "#!/bin/sh\nexit 7\n";
  const auto copy = sealed_copy(path);
  std::ofstream{path} << "#!/bin/sh\nexit 8\n";
  auto child = Child::spawn({.program = path, .copy = &*copy});
  ASSERT_TRUE(child.ok()) << to_text(child.problems());
  EXPECT_EQ(child->wait().code, 7);
  ::unlink(path.c_str());
}

TEST(Child, DoesNotInheritADescriptorThatSurvivesExec) {
  const Fd leaking{::open("/dev/null", O_RDONLY)};  // survives exec, as the sockets of some libraries do
  const Fd meant{::open("/dev/null", O_RDONLY | O_CLOEXEC)};
  SpawnOptions options = shell("test ! -e /proc/$$/fd/" + std::to_string(leaking.get()) +
                               " && test -e /proc/$$/fd/" + std::to_string(meant.get()));
  options.inherit = {&meant};
  auto child = Child::spawn(options);
  ASSERT_TRUE(child.ok());
  EXPECT_EQ(child->wait().code, 0);
}

TEST(Child, IsKilledByItsDestructor) {
  int pid = 0;
  {
    auto child = Child::spawn({.program = "/bin/sleep", .arguments = {"100"}});
    pid = child->pid();
    EXPECT_EQ(::kill(pid, 0), 0);
  }
  EXPECT_NE(::kill(pid, 0), 0);
}

TEST(Child, DiesWithItsParent) {
  auto ends = MessageSocket::pair();
  const int parent = ::fork();
  if (parent == 0) {
    auto child = Child::spawn({.program = "/bin/sleep", .arguments = {"100"}});
    ends->second.send(std::to_string(child->pid()));
    ::pause();
    ::_exit(0);
  }
  const int pid = std::stoi(ends->first.receive_wait().value());
  ::kill(parent, SIGKILL);
  ::waitpid(parent, nullptr, 0);
  expect_death(pid);
}

// Programs that start another process. This process prints its PID. The program ends on SIGTERM, unless it
// ignores SIGTERM.
struct Tree {
  std::string name;
  std::string script;
};
const std::vector<Tree> kTrees{
    {"a child", "sh -c 'echo $$; exec sleep 1000' & wait"},
    {"a child in its own session", "setsid sh -c 'echo $$; exec sleep 1000' & wait"},
    {"a daemon without a parent", "(setsid sh -c 'echo $$; exec sleep 1000' &); exec sleep 1000"},
    {"a daemon below a daemon",
     "(setsid sh -c '(setsid sh -c \"echo \\$\\$; exec sleep 1000\" &); exec sleep 1000' &); exec sleep "
     "1000"},
    {"a child that ignores SIGTERM", "(trap '' TERM; exec setsid sh -c 'echo $$; exec sleep 1000') & wait"},
    {"a shell that ignores SIGTERM", "trap '' TERM; setsid sh -c 'echo $$; exec sleep 1000' & wait"},
};

SpawnOptions whole_tree(const std::string& script) {
  SpawnOptions options = shell(script);
  options.capture_output = true;
  options.whole_tree = true;
  return options;
}

int read_pid(const Fd& output) {
  std::string text;
  for (bool end = false; !text.ends_with('\n') && !end;) {
    pollfd wanted{.fd = output.get(), .events = POLLIN, .revents = 0};
    ::poll(&wanted, 1, -1);
    text += read_available(output, &end);
  }
  return std::stoi(text);
}

int parent_of(int pid) {
  std::ifstream file{"/proc/" + std::to_string(pid) + "/status"};
  for (std::string word; file >> word;) {
    if (word == "PPid:") file >> pid;
  }
  return pid;
}

TEST(WholeTree, EndsWithItsProgram) {
  for (const Tree& tree : kTrees) {
    SCOPED_TRACE(tree.name);
    auto child = Child::spawn(whole_tree(tree.script));
    const int other = read_pid(child->output);
    child->signal(SIGTERM);
    if (tree.name == "a shell that ignores SIGTERM") child->signal(SIGKILL);
    const ProcessEnd end = child->wait();
    EXPECT_TRUE(end.signalled);
    EXPECT_NE(::kill(other, 0), 0) << "the end was reported before the other process had ended";
  }
}

TEST(WholeTree, EndsIfTheProgramExits) {
  auto child =
      Child::spawn(whole_tree("trap 'exit 3' TERM; setsid sh -c 'echo $$; exec sleep 1000' & wait; exit 4"));
  const int other = read_pid(child->output);
  child->signal(SIGTERM);
  std::optional<ProcessEnd> end;
  while (!(end = child->poll())) sleep_until(now() + milliseconds{1});
  EXPECT_EQ(end->text(), "ended with status 3, while processes that it had started still ran");
  EXPECT_NE(::kill(other, 0), 0);
}

TEST(WholeTree, EndsWithItsParent) {
  for (const Tree& tree : kTrees) {
    SCOPED_TRACE(tree.name);
    auto ends = MessageSocket::pair();
    const int parent = ::fork();
    if (parent == 0) {
      auto child = Child::spawn(whole_tree(tree.script));
      const int other = read_pid(child->output);
      ends->second.send(std::to_string(child->pid()) + " " + std::to_string(other));
      ::pause();
      ::_exit(0);
    }
    const std::string pids = ends->first.receive_wait().value();
    ::kill(parent, SIGKILL);
    ::waitpid(parent, nullptr, 0);
    expect_death(std::stoi(pids));
    expect_death(std::stoi(pids.substr(pids.find(' '))));
  }
}

TEST(WholeTree, GetsTimeToEndOnSigterm) {
  // On a busy machine, half a second may be too short. Then try again.
  std::string last;
  const Instant limit = now() + long_enough();
  while (last != "ended\n" && now() < limit) {
    auto child =
        Child::spawn(whole_tree("setsid sh -c 'trap \"echo ended; exit\" TERM; echo $$; while :; do sleep "
                                "1000 & wait; done' & wait"));
    read_pid(child->output);
    child->signal(SIGTERM);
    child->wait();
    bool end = false;
    last = read_available(child->output, &end);
  }
  EXPECT_EQ(last, "ended\n");
}

TEST(WholeTree, GetsSigtermInTheWholeProcessGroup) {
  // The shell calls its handler only when the process in the foreground has ended.
  auto child = Child::spawn(whole_tree("trap 'exit 4' TERM; sh -c 'echo $$; exec sleep 1000'; exit 5"));
  read_pid(child->output);
  child->signal(SIGTERM);
  EXPECT_EQ(child->wait().text(), "ended with status 4");
}

TEST(WholeTree, ReportsTheSignalThatKilledTheProgram) {
  EXPECT_EQ(Child::spawn(whole_tree("kill -SEGV $$"))->wait().text(),
            "was killed by SIGSEGV (Segmentation fault)");
}

TEST(WholeTree, HasThePidGroupAndEnvironmentOfItsProgram) {
  SpawnOptions options = whole_tree("echo $$ $(cut -d' ' -f5 /proc/$$/stat) $KEPT; test ! -e /proc/$$/fd/3");
  options.environment = {{"KEPT", "a=b c"}};
  auto child = Child::spawn(options);
  const std::string pid = std::to_string(child->pid());
  EXPECT_EQ(read_all(child->output), pid + " " + pid + " a=b c\n");
  EXPECT_EQ(child->wait().code, 0);
}

TEST(WholeTree, CannotStartAMissingProgram) {
  for (int i = 0; i < 20; ++i) {
    const auto missing = Child::spawn({.program = "/nowhere/program", .whole_tree = true});
    ASSERT_FALSE(missing.ok());
    EXPECT_THAT(to_text(missing.problems()), HasSubstr("/nowhere/program: No such file"));
  }
}

TEST(WholeTree, ExecutesACopyInsteadOfTheFile) {
  const auto copy = sealed_copy("/bin/sh");
  const auto child = Child::spawn({.program = "/nowhere/program",
                                   .copy = &*copy,
                                   .arguments = {"-c", "readlink /proc/$$/exe; test -e /proc/$$/fd/" +
                                                           std::to_string(copy->get()) + " || echo closed"},
                                   .capture_output = true,
                                   .whole_tree = true});
  ASSERT_TRUE(child.ok()) << to_text(child.problems());
  EXPECT_THAT(read_all(child->output), testing::MatchesRegex("/memfd:sh .*\nclosed\n"));
}

TEST(WholeTree, ExecutesTheCopyOfAScript) {
  const std::string path = testing::TempDir() + "takt-kept-" + std::to_string(::getpid());
  std::ofstream{path} << "#!/bin/sh\nexit 7\n";
  const auto copy = sealed_copy(path);
  ::unlink(path.c_str());
  auto child = Child::spawn({.program = path, .copy = &*copy, .whole_tree = true});
  ASSERT_TRUE(child.ok()) << to_text(child.problems());
  EXPECT_EQ(child->wait().code, 7);
}

TEST(WholeTree, EndsIfOneOfItsKeepersIsKilled) {
  for (const Tree& tree : kTrees) {
    for (const bool outer : {false, true}) {
      SCOPED_TRACE(tree.name + (outer ? ", outer keeper" : ", inner keeper"));
      auto child = Child::spawn(whole_tree(tree.script));
      const int other = read_pid(child->output);
      const int inner = parent_of(child->pid());
      ::kill(outer ? parent_of(inner) : inner, SIGKILL);
      EXPECT_EQ(child->wait().text(), "was killed by SIGKILL (Killed), because its takt-keeper was killed");
      EXPECT_NE(::kill(other, 0), 0) << "the end was reported before the other process had ended";
    }
  }
}

TEST(WholeTree, KeepsOtherProcessesUntilTheChildIsDestroyedIfTheyStay) {
  for (const Tree& tree : kTrees) {
    SCOPED_TRACE(tree.name);
    SpawnOptions options = whole_tree(tree.script);
    options.others_stay = true;
    int other = 0;
    {
      auto child = Child::spawn(options);
      other = read_pid(child->output);
      ::kill(child->pid(), SIGKILL);
      while (!child->poll()) sleep_until(now() + milliseconds{1});
      EXPECT_FALSE(is_dead(other));
    }
    EXPECT_NE(::kill(other, 0), 0);
    {
      auto child = Child::spawn(options);
      other = read_pid(child->output);
    }
    EXPECT_NE(::kill(other, 0), 0) << "the program still ran when the child was destroyed";
  }
}

TEST(WorkInChild, ReturnsItsResult) {
  EXPECT_EQ(in_child(
                "it", [] { return std::string{"result"}; }, seconds{30})
                .value(),
            "result");
  const std::string large(1'000'000, 'x');
  EXPECT_TRUE(in_child(
                  "it", [&large] { return large; }, seconds{30})
                  .value() == large);
  EXPECT_EQ(in_child(
                "it", [] { return std::string{}; }, seconds{30})
                .value(),
            "");
}

TEST(WorkInChild, CanCrashWithoutEndingTheParent) {
  const auto result = in_child(
      "loading it",
      []() -> std::string {
        ::signal(SIGSEGV, SIG_DFL);
        ::raise(SIGSEGV);
        return "not reached";
      },
      seconds{30});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.problems()[0].what, "loading it was killed by SIGSEGV (Segmentation fault)");
}

TEST(WorkInChild, IsKilledIfItHangs) {
  const auto result = in_child(
      "loading it",
      []() -> std::string {
        while (true) ::pause();
      },
      milliseconds{50});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.problems()[0].what, "loading it did not end within 50 ms");
}

TEST(WorkInChild, HasNoResultIfItExitsBeforeItReturns) {
  const auto result = in_child(
      "loading it", []() -> std::string { ::_exit(0); }, seconds{30});
  EXPECT_TRUE(!result.ok() || result->empty());
  const auto other = in_child(
      "loading it", []() -> std::string { ::_exit(4); }, seconds{30});
  ASSERT_FALSE(other.ok());
  EXPECT_EQ(other.problems()[0].what, "loading it ended with status 4");
}

}  // namespace
}  // namespace takt::os::process_test
