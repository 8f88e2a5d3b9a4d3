// What the kernel answered, in words.
#pragma once

#include <string>

#include <takt/core/result.hpp>

namespace takt::os {

/// "CALL: No such file or directory" from errno.
Problem errno_problem(std::string call, std::string fix = {});
/// The same from an error number. A process that may open no more files is told what helps, whatever `fix`
/// says.
Problem error_problem(std::string call, int error, std::string fix = {});

}  // namespace takt::os
