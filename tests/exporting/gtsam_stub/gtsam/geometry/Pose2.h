#pragma once
#include <gtsam/stub.h>
