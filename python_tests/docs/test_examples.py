"""The examples of the documentation: a server of attitude over UDP, and the notebook."""

import importlib.util
import socket
import threading

import numpy as np
import pytest

from checkout import TOP

spec = importlib.util.spec_from_file_location("realtime", TOP / "docs" / "realtime.py")
realtime = importlib.util.module_from_spec(spec)
spec.loader.exec_module(realtime)


def local_socket():
    here = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    here.bind(("127.0.0.1", 0))
    here.settimeout(20)
    return here


def test_attitude_in_real_time_over_udp():
    n, begun = 300, 5  # a start takes two samples of the field
    with local_socket() as server, local_socket() as client:
        thread = threading.Thread(target=realtime.serve, args=(server, client.getsockname(), n), daemon=True)
        thread.start()
        client.sendto(b"no sample\xff", server.getsockname())
        answers = []
        for k in range(n):  # level, nose to the east, a field in every fifth sample
            field = "0 -20e-6 45e-6" if k % 5 == 0 else "nan nan nan"
            client.sendto(f"{0.01 * k} 0 0 0 0 0 -9.81 {field}".encode(), server.getsockname())
            if k >= begun:
                answers.append([float(word) for word in client.recv(4096).split()])
        thread.join(timeout=20)
        assert not thread.is_alive()
    answers = np.array(answers)
    assert np.allclose(answers[:, 0], 0.01 * np.arange(begun, n))
    assert np.allclose(answers[-1, 1:5], [np.sqrt(0.5), 0, 0, np.sqrt(0.5)], atol=1e-6)
    assert answers[-1, 5] == pytest.approx(90, abs=1e-3) and 0 < answers[-1, 6] < 20


def test_what_cannot_be_used_is_named_and_the_server_goes_on(capsys):
    with local_socket() as server, local_socket() as client:
        for sample in (*(f"{t} 0 0 0 0 0 -9.81 2e-5 0 4.5e-5" for t in (0, 0.01, -0.5)), "0.02 0 0 0 0 0 -9.81 nan nan nan"):
            client.sendto(sample.encode(), server.getsockname())
        realtime.serve(server, client.getsockname(), 4)
        assert [float(client.recv(4096).split()[0]) for _ in range(2)] == [0.01, 0.02]
    assert capsys.readouterr().err.count("\n") == 2  # no attitude yet, and a sample from the past


def test_the_notebook_runs():
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed: the notebook is not run")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed: the notebook is not run")
    import nbformat

    notebook = nbformat.read(TOP / "docs" / "tour.ipynb", as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "a notebook is kept without its outputs"
    nbclient.NotebookClient(notebook, timeout=60, kernel_name="python3").execute()  # raises what a cell raises
    printed = "".join(out.get("text", "") for cell in notebook.cells for out in cell.get("outputs", ()))
    assert "inside three sigma: [1. 1. 1.]" in printed
