// Turns error numbers of the kernel into problems.
#pragma once

#include <string>

#include <takt/core/result.hpp>

namespace takt::os {

/// The problem for errno: "CALL: No such file or directory".
Problem errno_problem(std::string call, std::string fix = {});
/// The problem for an error number. If the process has too many open files, the remedy for that replaces
/// `fix`.
Problem error_problem(std::string call, int error, std::string fix = {});

}  // namespace takt::os
