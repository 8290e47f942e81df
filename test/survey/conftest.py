import sys
from pathlib import Path

# Beside the tests, because the import mode knows no packages of tests.
sys.path.insert(0, str(Path(__file__).parent))
