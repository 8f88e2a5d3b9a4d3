// Processes that clean up after other processes: takt-keeper, and the first process of a container.
#pragma once

namespace takt::os {

/// The program of takt-keeper. It starts a program, and ends all processes that the program has started when
/// the program or its node ends. Only Child::spawn() starts takt-keeper, with these arguments:
///
///     takt-keeper FAILURE STATUS COPY OTHERS_STAY NAME=VALUE... -- PROGRAM [ARGUMENT...]
///
/// FAILURE is a pipe that gets the error number if the program cannot be executed. STATUS is a pipe that gets
/// a KeptStart, and later a KeptEnd. COPY is the file to execute instead of PROGRAM, or -1. OTHERS_STAY is 1
/// or 0, as in SpawnOptions.
///
/// takt-keeper consists of two processes: the parent of the program, and the parent of this parent. If one of
/// them is killed, the other one ends all processes of the program, and then closes STATUS without a KeptEnd.
int keep(int count, char** arguments);

/// What takt-keeper writes when it has started the program.
struct KeptStart {
  int pid = 0;
};

/// What takt-keeper writes when no process of the program is left, or, if the others stay, when the program
/// has ended. The program itself remains a zombie until SIGTERM ends takt-keeper, so its PID is not used
/// again before.
struct KeptEnd {
  int signalled = 0;
  int code = 0;  ///< as in ProcessEnd
  int left_others = 0;
};

/// The kernel expects the first process of a container (PID 1) to reap processes whose parent has ended. If
/// this process is the first, the call returns only in a new child process. The first process then reaps,
/// passes signals on to the child, and ends with the child's exit status. Call this before any thread begins.
void run_below_first_process();

}  // namespace takt::os
