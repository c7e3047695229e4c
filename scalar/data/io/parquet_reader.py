"""Read Parquet files as tables of numbers and, in the columns that the layout says, text; damaged files are refused."""

from pathlib import Path
from typing import Any

import numpy as np

from scalar.data.io.regular_file import MAX_TABLE_BYTES, check_regular_file
from scalar.data.located_table import Layout, Table, check_cells, header_faults
from scalar.errors import Fault, InvalidInput


def read_parquet(path: Path, layout: Layout, faults: list[Fault]) -> Table | None:
    """Return the table in a Parquet file, None if nothing of it can be used; faults are added."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    file = path.name
    try:
        check_regular_file(path, MAX_TABLE_BYTES)
    except InvalidInput as error:
        faults += error.faults
        return None
    try:
        with pq.ParquetFile(path) as parquet:
            names = parquet.schema_arrow.names
            used = [name for name in dict.fromkeys(names) if name in {*layout.required, *layout.optional}]
            _refuse_too_large(file, parquet, len(used))
            content = parquet.read(columns=used)
    except InvalidInput as error:
        faults += error.faults
        return None
    except Exception as error:  # a damaged file makes pyarrow raise nearly anything
        reason = " ".join(str(error).split())[:80]
        faults.append(
            Fault(file, f"cannot be read as Parquet ({reason}); it may be cut short: write or copy it again")
        )
        return None
    faults += header_faults(file, names, layout, None)
    table = Table(file, {}, lambda: np.arange(1, content.num_rows + 1))
    for name in (*layout.required, *(name for name in layout.optional if name in content.column_names)):
        if content.column_names.count(name) != 1:
            continue
        column = content[name]
        if pa.types.is_dictionary(column.type):
            column = column.cast(column.type.value_type)
        kind = column.type
        if name in layout.text:
            table.columns[name] = np.array([str(cell or "").strip() for cell in column.to_pylist()], object)
            continue
        if not (pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind)):
            faults.append(Fault(file, f"holds {kind}, not numbers; write it as double or int64", column=name))
            continue
        table.columns[name] = column.cast(pa.float64(), safe=False).to_numpy()
        empty = column.is_null().to_numpy()
        table.report(faults, name, empty, lambda i: "an empty cell; write the number, or remove the row")
    check_cells(table, layout, faults)
    return table


def _refuse_too_large(file: str, parquet: Any, columns: int) -> None:
    """Refuse a file whose content is larger than a table may be, by what its end says: compressed, zeros without end are a small file."""
    groups = (parquet.metadata.row_group(k) for k in range(parquet.metadata.num_row_groups))
    size = max(8 * columns * parquet.metadata.num_rows, sum(group.total_byte_size for group in groups))
    if size > MAX_TABLE_BYTES:
        message = f"holds {size / 1e6:.0f} MB of data, more than the {MAX_TABLE_BYTES // 1_000_000} MB that are read of a table; make it shorter"
        raise InvalidInput(Fault(file, message))
