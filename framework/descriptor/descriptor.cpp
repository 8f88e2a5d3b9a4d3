#include <takt/descriptor/descriptor.hpp>
