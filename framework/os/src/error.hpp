// Turns error numbers of the kernel into problems.
#pragma once

#include <string>

#include <takt/core/result.hpp>

namespace takt::os {

/// The problem of errno: "CALL: No such file or directory".
Problem errno_problem(std::string call, std::string fix = {});
/// The same for an error number. If the process has too many open files, `fix` is replaced by the remedy for
/// that.
Problem error_problem(std::string call, int error, std::string fix = {});

}  // namespace takt::os
